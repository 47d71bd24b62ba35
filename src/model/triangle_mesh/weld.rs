//! Merges corners with equal coordinates into one vertex.

use std::hash::{BuildHasher, RandomState};

use super::TriangleMesh;
use crate::Vector;

const FREE: u32 = u32::MAX;

/// A mesh under construction. A hash table of 4-byte indices finds vertices by their coordinates. A map with
/// coordinates as keys would need more memory than the file. Random hash keys protect against crafted files.
#[derive(Debug, Default)]
pub(crate) struct Welder {
    mesh: TriangleMesh,
    table: Vec<u32>,
    keys: RandomState,
}

impl Welder {
    pub fn push(&mut self, corners: &[Vector; 3]) {
        let numbers = corners.map(|corner| self.number(corner));
        grow_by_a_little(&mut self.mesh.triangles);
        self.mesh.triangles.push(numbers);
    }

    pub fn len(&self) -> usize {
        self.mesh.triangles.len()
    }

    pub fn finish(self) -> TriangleMesh {
        let mut mesh = self.mesh;
        mesh.vertices.shrink_to_fit();
        mesh.triangles.shrink_to_fit();
        mesh
    }

    /// Returns the index of the vertex at a point, and adds the vertex if it is new.
    pub fn number(&mut self, point: Vector) -> u32 {
        // Turns -0.0 into 0.0.
        let point = point.add_scalar(0.0);
        if 10 * (self.mesh.vertices.len() + 1) > 9 * self.table.len() {
            self.enlarge();
        }
        let place = self.place(&point);
        match self.table.get_mut(place) {
            Some(entry) if *entry == FREE => {
                let number = u32::try_from(self.mesh.vertices.len()).unwrap_or(FREE);
                *entry = number;
                grow_by_a_little(&mut self.mesh.vertices);
                self.mesh.vertices.push(point);
                number
            }
            found => found.copied().unwrap_or(FREE),
        }
    }

    /// Returns the slot of a vertex in the hash table, or the empty slot where it belongs.
    fn place(&self, point: &Vector) -> usize {
        let bits = [point.x, point.y, point.z].map(f64::to_bits);
        let is_same = |number: u32| {
            self.mesh.vertices.get(number as usize).is_some_and(|v| [v.x, v.y, v.z].map(f64::to_bits) == bits)
        };
        let wide = u128::from(self.keys.hash_one(bits)) * self.table.len() as u128;
        let start = usize::try_from(wide >> 64).unwrap_or(0);
        let (before, after) = self.table.split_at(start.min(self.table.len()));
        let found = |table: &[u32]| table.iter().position(|&entry| entry == FREE || is_same(entry));
        found(after).map(|place| start + place).or_else(|| found(before)).unwrap_or(0)
    }

    /// Frees the old table before the new table is filled, to save memory.
    fn enlarge(&mut self) {
        let size = (self.table.len() + self.table.len() / 5).max(16);
        self.table = Vec::new();
        self.table = vec![FREE; size];
        for number in 0..self.mesh.vertices.len() {
            if let Some(place) = self.mesh.vertices.get(number).map(|point| self.place(point))
                && let Some(entry) = self.table.get_mut(place)
            {
                *entry = u32::try_from(number).unwrap_or(FREE);
            }
        }
    }
}

/// Reserves memory in small steps. Saving memory matters more here than avoiding copies.
fn grow_by_a_little<T>(list: &mut Vec<T>) {
    if list.len() == list.capacity() {
        list.reserve_exact(list.len() / 16 + 16);
    }
}
