//! Systems of few particles, where `N` and `N - 1` differ noticeably.

use std::f64::consts::PI;

use carom::Vector;
use carom::analysis::observables::Observer;
use carom::analysis::statistics::Estimate;
use carom::engine::Simulation;
use carom::model::space::{Boundary, Space};
use carom::model::{RunPlan, Scene, Thermostat, Until};
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

use super::measure::{Mean, finish};

/// Hard spheres at random positions in a periodic cube. The mass is not a power of 2.
fn spheres(count: u64, edge: f64, events: u64) -> Scene {
    SceneBuilder::new("few")
        .seed(3)
        .space(Space::periodic_cube(edge))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(count))
        .temperature(1.0)
        .run(RunPlan { equilibration: Until::events(1000 * count), limit: Until::events(events), ..RunPlan::default() })
        .build()
        .unwrap()
}

fn observed(scene: Scene, name: &str) -> Estimate {
    finish(scene).observable(name).unwrap()
}

fn compressibility(count: u64, edge: f64, events: u64) -> Estimate {
    observed(spheres(count, edge, events), "compressibility_factor")
}

#[test]
fn two_spheres_in_a_small_cube_have_their_exact_pressure() {
    // The first particle may be anywhere in the volume V. It excludes the second particle from the volume v = 4 pi / 3.
    // If the cube is longer than two diameters, the partition function is Q = V (V - v). Then P / T = d ln Q / dV = 1 /
    // V + 1 / (V - v), and Z = P V / (2 T).
    let (volume, excluded) = (27.0, 4.0 * PI / 3.0);
    let exact = 0.5 * (1.0 + volume / (volume - excluded));
    assert!((exact - 1.09181).abs() < 1e-5);
    let z = compressibility(2, 3.0, 300_000);
    let error = z.standard_error.unwrap();
    println!("N = 2: {z:?}, exact {exact}");
    assert!(error < 0.001 && (z.mean - exact).abs() < 4.0 * error, "{z:?}, exact {exact}");
}

#[test]
fn few_spheres_have_the_pressure_of_a_monte_carlo_simulation() {
    for (count, edge, events, sweeps) in [(4, 2.2, 300_000, 600_000), (32, 3.823, 400_000, 60_000)] {
        let z = compressibility(count, edge, events);
        let expected = MonteCarlo::new(count, edge).compressibility(sweeps);
        let error = libm::hypot(z.standard_error.unwrap(), expected.error);
        println!("N = {count}: {z:?}, {expected:?}, {:+.2} sigma", (z.mean - expected.mean) / error);
        // Counting one particle too many would change Z by (Z - 1) / N.
        assert!(error < (expected.mean - 1.0) / (5.0 * count as f64), "{count}: {error}");
        assert!((z.mean - expected.mean).abs() < 3.0 * error, "{count}: {z:?}, {expected:?}");
    }
}

/// Metropolis Monte Carlo simulation of hard spheres in a periodic cube, without code of the engine.
struct MonteCarlo {
    edge: f64,
    positions: Vec<[f64; 3]>,
    state: u64,
}

impl MonteCarlo {
    fn new(count: u64, edge: f64) -> Self {
        let cells = (1..).find(|n| 4 * n * n * n >= count).unwrap();
        let step = edge / cells as f64;
        let mut positions = Vec::new();
        for cell in 0..cells * cells * cells {
            let corner = [cell % cells, cell / cells % cells, cell / cells / cells].map(|n| n as f64 * step);
            for face in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
                positions.push(std::array::from_fn(|k| corner[k] + face[k] * step));
            }
        }
        positions.truncate(usize::try_from(count).unwrap());
        Self { edge, positions, state: 7 }
    }

    /// SplitMix64.
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn squared_distance(&self, a: &[f64; 3], b: &[f64; 3]) -> f64 {
        let along = |k: usize| {
            let d = a[k] - b[k];
            d - self.edge * (d / self.edge).round()
        };
        (0..3).map(|k| along(k) * along(k)).sum()
    }

    fn sweep(&mut self) {
        for i in 0..self.positions.len() {
            let old = self.positions[i];
            let new = old.map(|x| (x + 0.5 * (self.uniform() - 0.5)).rem_euclid(self.edge));
            let is_free = |j: usize| j == i || self.squared_distance(&new, &self.positions[j]) >= 1.0;
            if (0..self.positions.len()).all(is_free) {
                self.positions[i] = new;
            }
        }
    }

    /// Counts the pairs in shells near contact, and divides by the numbers of an ideal gas. A parabola extrapolates
    /// these ratios to `g(1)` at contact: `Z = 1 + (2 pi / 3) rho (N - 1) / N g(1)`.
    fn compressibility(mut self, sweeps: u64) -> Mean {
        const SHELLS: usize = 10;
        const WIDTH: f64 = 0.01;
        const BLOCKS: u64 = 30;
        let count = self.positions.len() as f64;
        let volume = self.edge.powi(3);
        (0..sweeps / 20).for_each(|_| self.sweep());
        let mut blocks = Vec::new();
        for _ in 0..BLOCKS {
            let mut pairs = [0.0; SHELLS];
            for _ in 0..sweeps / BLOCKS {
                self.sweep();
                for (i, a) in self.positions.iter().enumerate() {
                    for b in &self.positions[..i] {
                        let squared = self.squared_distance(a, b);
                        if squared < (1.0 + SHELLS as f64 * WIDTH).powi(2) {
                            #[expect(clippy::cast_possible_truncation, reason = "one of SHELLS, up to rounding")]
                            let shell = ((squared.sqrt() - 1.0) / WIDTH) as usize;
                            pairs[shell.min(SHELLS - 1)] += 1.0;
                        }
                    }
                }
            }
            let samples = (sweeps / BLOCKS) as f64;
            let points = pairs.iter().enumerate().map(|(shell, number)| {
                let [from, to] = [shell, shell + 1].map(|edge| 1.0 + edge as f64 * WIDTH);
                let ideal = 0.5 * count * (count - 1.0) * 4.0 * PI / 3.0 * (to.powi(3) - from.powi(3)) / volume;
                (shell as f64 + 0.5, number / (samples * ideal))
            });
            let contact = at_zero(&points.collect::<Vec<_>>());
            blocks.push(1.0 + 2.0 * PI / 3.0 * (count - 1.0) / volume * contact);
        }
        Mean::of(blocks)
    }
}

/// Fits a parabola by least squares and returns its value at 0.
fn at_zero(points: &[(f64, f64)]) -> f64 {
    let sum = |power: i32| points.iter().map(|(x, _)| x.powi(power)).sum::<f64>();
    let moment = |power: i32| points.iter().map(|(x, y)| x.powi(power) * y).sum::<f64>();
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let row = |k: i32| [sum(k), sum(k + 1), sum(k + 2)];
    let with = |k: i32| [moment(k), sum(k + 1), sum(k + 2)];
    determinant([with(0), with(1), with(2)]) / determinant([row(0), row(1), row(2)])
}

fn disks(boundary: [Boundary; 2], thermostat: Option<Thermostat>) -> Scene {
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(12.0, 12.0, 0.0),
        boundary: [boundary[0], boundary[1], Boundary::Flat],
    };
    SceneBuilder::new("disks")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(40))
        .temperature(1.0)
        .run(RunPlan { limit: Until::events(2_000), thermostat, ..RunPlan::default() })
        .build()
        .unwrap()
}

#[test]
fn measured_temperature_equals_the_requested_one() {
    let (periodic, walls) = (Boundary::Periodic, Boundary::walls(1.0));
    for boundary in [[periodic; 2], [walls, periodic], [periodic, walls], [walls; 2]] {
        let scene = disks(boundary, None);
        let first = Observer::new(&scene).row(&Simulation::without_plan(scene.clone())).temperature.unwrap();
        let temperature = observed(scene, "temperature");
        let is_one = |value: f64| (value - 1.0).abs() < 1e-13;
        assert!(is_one(first) && is_one(temperature.mean), "{boundary:?}: {first} {temperature:?}");
    }
    // A heat bath along x does not change the momentum along y.
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [true, false, false] };
    let scene = disks([periodic; 2], Some(bath));
    let first = Observer::new(&scene).row(&Simulation::without_plan(scene)).temperature.unwrap();
    assert!((first - 1.0).abs() < 1e-13, "{first}");
    // Rescaling and measuring the temperature use the same number of degrees of freedom.
    let scaled = Thermostat::Rescaling { temperature: 2.0, interval: 0.1 };
    let temperature = observed(disks([walls, periodic], Some(scaled)), "temperature").mean;
    assert!((temperature - 2.0).abs() < 1e-13, "{temperature}");
}
