//! An exact oracle for event detection, and a comparison of every detection function with it. The input of detection
//! consists of floating-point numbers, so the coefficients of an overlap function are dyadic rationals. The oracle
//! decides in integers, without a tolerance.
//!
//! | modules | |
//! |---|---|
//! | `dyadic`, `polynomial`, `sturm`, `crossing` | exact numbers, polynomials, counts of roots, and brackets of any width |
//! | `rule`, `exact` | the oracle: the rule, and exact overlap functions with the rounding of their floating-point forms |
//! | `detection`, `compare`, `witness`, `measure` | the calls, and how an answer is judged |
//! | `cases`, `hard_cases`, `random` | states, by family |
//! | `hand`, `agreement`, `regressions` | tests: of the oracle itself, of all functions, of every failure ever found |
//! | `surfaces` | the same for points, lines, segments, faces and planes, where the foot must be on the feature |
//! | `tally`, `evaluations`, `totals`, `table` | counts of all algorithms and families, and `benches/results/detection.md` |
//!
//! `CAROM_ORACLE` is the number of states in each family. With 50,000, each algorithm gets more than 10^6 states in
//! about twenty minutes, and the table is written:
//!
//! ```text
//! CAROM_ORACLE=50000 cargo test --release --test oracle -- --nocapture
//! ```

mod agreement;
mod cases;
mod compare;
mod crossing;
mod detection;
mod dyadic;
mod evaluations;
mod exact;
mod hand;
mod hard_cases;
mod measure;
mod polynomial;
mod random;
mod regressions;
mod rule;
mod sturm;
mod surfaces;
mod table;
mod tally;
mod totals;
mod witness;

fn per_family(usual: usize) -> usize {
    std::env::var("CAROM_ORACLE").map_or(usual, |states| states.parse().unwrap())
}
