//! The long run and its table: `cargo test --release --test oracle -- --ignored --nocapture long_run`.

use crate::detection::Algorithm;
use crate::table::{family_row, page};
use crate::tally::{Tally, run};

/// With 21 families this gives more than 10^6 states of each algorithm.
const PER_FAMILY: usize = 50_000;

const SEED: u64 = 1_996_000;

#[test]
#[ignore = "takes about ten minutes; writes benches/results/detection.md"]
fn long_run() {
    let mut totals = Vec::new();
    let mut families = String::new();
    for algorithm in Algorithm::ALL {
        let mut total = Tally::default();
        for (name, mut tally) in run(algorithm, PER_FAMILY, SEED) {
            family_row(&mut families, algorithm, name, &mut tally);
            total.append(tally);
        }
        for (state, comparison) in &total.wrong {
            eprintln!("{} {state:?}: {comparison:?}", algorithm.name());
        }
        eprintln!("{}: {} cases, {} wrong", algorithm.name(), total.cases, total.wrong_count);
        totals.push((algorithm, total));
    }
    let wrong: usize = totals.iter().map(|(_, total)| total.wrong_count).sum();
    let page = page(&mut totals, &families, SEED);
    std::fs::create_dir_all("benches/results").expect("the folder can be made");
    std::fs::write("benches/results/detection.md", page).expect("the table can be written");
    assert_eq!(wrong, 0, "verdicts or times are wrong");
}
