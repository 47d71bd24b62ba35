//! Writes the silo of `configs/silo.toml` to an STL file: a square bin above a pyramid that is open at the bottom.
//!
//!     cargo run --release --example draw_silo

use carom::Vector;
use carom::mesh::write_stl;
use carom::model::TriangleMesh;

/// Half widths and heights `[length]` at the outlet, at the upper end of the pyramid, and at the top.
type Profile = [[f64; 2]; 3];

const INSIDE: Profile = [[2.5, 0.0], [6.0, 6.0], [6.0, 41.0]];
const OUTSIDE: Profile = [[2.9, 0.0], [6.4, 6.0], [6.4, 41.0]];

/// Corner `k` of a square around the axis, counted counterclockwise as seen from above.
fn corner([half_width, height]: [f64; 2], k: usize) -> Vector {
    let [x, y] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][k % 4];
    Vector::new(x * half_width, y * half_width, height)
}

/// The silo. The triangles face out of the material.
fn silo() -> TriangleMesh {
    let mut squares = Vec::new();
    for k in 0..4 {
        let strip = |lower, upper| [corner(lower, k), corner(lower, k + 1), corner(upper, k + 1), corner(upper, k)];
        for level in 0..2 {
            squares.push(strip(OUTSIDE[level], OUTSIDE[level + 1]));
            squares.push(strip(INSIDE[level + 1], INSIDE[level]));
        }
        // Closes the wall at the outlet and at the top.
        squares.push(strip(INSIDE[0], OUTSIDE[0]));
        squares.push(strip(OUTSIDE[2], INSIDE[2]));
    }
    TriangleMesh::welded(squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = silo();
    write_stl(&mesh, &mut std::fs::File::create("configs/silo.stl")?)?;
    println!("configs/silo.stl: {} triangles, enclosed volume {:.1}", mesh.triangles.len(), mesh.enclosed_volume());
    Ok(())
}
