use carom::Run;
use carom::analysis::instruments::Measured;
use carom::engine::event::Event;
use carom::engine::{Reason, Simulation, Until};
use carom::model::{Potential, Scene};
use carom::run::Finished;

/// Hard spheres with this contact distance.
pub fn hard(distance: f64) -> Potential {
    Potential::hard_sphere(distance).unwrap()
}

/// Runs a scene to its end and asserts that the audit finds no fault.
pub fn finish(scene: Scene) -> Finished {
    let finished = Run::new(scene).finish().unwrap();
    assert_eq!(finished.audit.faults(), []);
    finished
}

/// Returns the mean and the standard error of a measured number.
pub fn number(measured: &Measured, name: &str) -> (f64, f64) {
    let number = measured.number(name).unwrap();
    (number.mean.unwrap(), number.standard_error.unwrap_or_else(|| panic!("{number:?}")))
}

#[derive(Debug, Clone, Copy)]
pub struct Mean {
    pub mean: f64,
    pub error: f64,
}

impl Mean {
    pub fn of(samples: impl IntoIterator<Item = f64>) -> Self {
        let samples: Vec<f64> = samples.into_iter().collect();
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let variance = samples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
        Self { mean, error: (variance / n).sqrt() }
    }

    /// Asserts agreement with theory within four standard errors. The standard error must be below `resolution`.
    #[track_caller]
    pub fn assert_is(&self, expected: f64, resolution: f64, what: &str) {
        let Self { mean, error } = *self;
        println!("{what}: {mean:.6} +- {error:.6}, expected {expected:.6}, {:+.2} sigma", (mean - expected) / error);
        assert!(error < resolution, "{what}: the standard error {error} is not below {resolution}");
        assert!((mean - expected).abs() < 4.0 * error, "{what} is {mean} +- {error}, expected {expected}");
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Block {
    pub time: f64,
    pub temperature: f64,
    pub core: f64,
    /// Sum of `r_ij . J` over contacts, with the separation `r_ij` and the impulse `J`.
    pub virial: f64,
}

/// A fluid without external forces, measured in blocks.
#[derive(Debug)]
pub struct Fluid {
    pub particles: f64,
    pub dimensions: f64,
    pub blocks: Vec<Block>,
}

impl Fluid {
    /// Runs `equilibration` events, then measures `count` blocks of `events` each. Calls `observe` for every measured
    /// event, with the number of the block.
    pub fn measure_with(
        simulation: &mut Simulation,
        equilibration: u64,
        count: usize,
        events: u64,
        mut observe: impl FnMut(usize, &Event),
    ) -> Self {
        let (particles, dimensions) = (simulation.moving() as f64, simulation.dimensions() as f64);
        let start = simulation.event_counts().physical();
        assert_eq!(simulation.advance(Until::events(start + equilibration)), Ok(Reason::Events));
        let mut kinetic = simulation.energy().kinetic;
        let mut now = simulation.time();
        let mut blocks = Vec::new();
        for block in 0..count {
            let (before, begin, mut integral) = (*simulation.event_counts(), now, 0.0);
            let reason = simulation.advance_with(Until::events(before.physical() + events), |event| {
                integral += kinetic * (event.time - now);
                kinetic -= event.energy_step + event.dissipated;
                now = event.time;
                observe(block, event);
            });
            assert_eq!(reason, Ok(Reason::Events));
            let after = simulation.event_counts();
            blocks.push(Block {
                time: now - begin,
                // The total momentum is zero, so there are D (N - 1) degrees of freedom.
                temperature: 2.0 * integral / (now - begin) / (dimensions * (particles - 1.0)),
                core: (after.core - before.core) as f64,
                virial: after.virial.total() - before.virial.total(),
            });
        }
        Self { particles, dimensions, blocks }
    }

    pub fn measure(simulation: &mut Simulation, equilibration: u64, count: usize, events: u64) -> Self {
        Self::measure_with(simulation, equilibration, count, events, |_, _| {})
    }

    pub fn mean(&self, of: impl Fn(&Block) -> f64) -> Mean {
        Mean::of(self.blocks.iter().map(of))
    }

    pub fn temperature(&self) -> Mean {
        self.mean(|block| block.temperature)
    }

    /// The compressibility factor `Z = 1 + sum r_ij . J / (D N T t)`.
    pub fn compressibility(&self) -> Mean {
        self.mean(|b| 1.0 + b.virial / (self.dimensions * self.particles * b.temperature * b.time))
    }

    /// Contacts per particle and time, scaled to temperature 1. Each contact counts for both particles.
    pub fn collision_rate(&self) -> Mean {
        self.mean(|b| 2.0 * b.core / (self.particles * b.time * b.temperature.sqrt()))
    }
}
