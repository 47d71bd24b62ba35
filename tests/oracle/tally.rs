use crate::cases::FAMILIES;
use crate::compare::{Comparison, Judgement, compare};
use crate::detection::Algorithm;
use crate::evaluations::{Evaluations, evaluations};
use crate::exact::State;
use crate::random::Random;
use crate::rule::Verdict;
use carom::Vector;

#[derive(Debug, Default)]
pub struct Tally {
    pub cases: usize,
    pub events_later: usize,
    pub within_rounding: usize,
    pub wrong: Vec<(State, Comparison)>,
    pub wrong_count: usize,
    /// Errors of times [ulp].
    pub errors: Vec<f64>,
    /// Errors of times, divided by the allowed errors.
    pub ratios: Vec<f64>,
    pub evaluations: Evaluations,
}

const SHOWN: usize = 5;

impl Tally {
    fn add(&mut self, algorithm: Algorithm, state: &State) {
        let comparison = compare(algorithm, state);
        self.cases += 1;
        self.events_later += usize::from(matches!(comparison.verdict, Verdict::Later(..)));
        match comparison.judgement {
            Judgement::Right => {
                if let Some(distance) = comparison.distance {
                    self.errors.push(distance.error.abs());
                    self.ratios.push(distance.ratio());
                    self.evaluations.append(evaluations(algorithm, state, &comparison));
                }
            }
            Judgement::WithinRounding => self.within_rounding += 1,
            Judgement::Wrong(_) => {
                self.wrong_count += 1;
                if self.wrong.len() < SHOWN {
                    self.wrong.push((*state, comparison));
                }
            }
        }
    }

    pub fn append(&mut self, other: Self) {
        self.cases += other.cases;
        self.events_later += other.events_later;
        self.within_rounding += other.within_rounding;
        self.wrong_count += other.wrong_count;
        self.wrong.extend(other.wrong);
        self.errors.extend(other.errors);
        self.ratios.extend(other.ratios);
        self.evaluations.append(other.evaluations);
    }
}

pub fn run(algorithm: Algorithm, per_family: usize, seed: u64) -> Vec<(&'static str, Tally)> {
    FAMILIES
        .iter()
        .enumerate()
        .map(|(number, (name, family))| {
            let mut random = Random::new(seed + number as u64);
            let mut tally = Tally::default();
            for _ in 0..per_family {
                let falling = algorithm.takes_acceleration().unwrap_or_else(|| random.chance(0.7));
                let mut state = family(&mut random, falling);
                if algorithm.takes_acceleration() == Some(true) && state.acceleration == Vector::zeros() {
                    state.acceleration.z = -1.0;
                }
                tally.add(algorithm, &state);
            }
            (*name, tally)
        })
        .collect()
}

/// Returns the median, the 99.9 % quantile and the largest value, or zeros for an empty list.
pub fn spread(values: &mut [f64]) -> [f64; 3] {
    if values.is_empty() {
        return [0.0; 3];
    }
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    [values[last / 2], values[last * 999 / 1000], values[last]]
}
