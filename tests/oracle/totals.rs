//! The table of all algorithms and families. With `CAROM_ORACLE`, the table is written to `benches/results`.

use crate::detection::Algorithm;
use crate::per_family;
use crate::table::{family_row, page};
use crate::tally::{Tally, run};

const PER_FAMILY: usize = 50;

const SEED: u64 = 1_996_000;

#[test]
fn no_verdict_in_the_table_is_wrong() {
    let mut totals = Vec::new();
    let mut families = String::new();
    for algorithm in Algorithm::ALL {
        let mut total = Tally::default();
        for (name, mut tally) in run(algorithm, per_family(PER_FAMILY), SEED) {
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
    assert!(Algorithm::ALL.iter().all(|algorithm| page.contains(algorithm.name())), "{page}");
    if std::env::var_os("CAROM_ORACLE").is_some() {
        std::fs::write("benches/results/detection.md", page).expect("the table can be written");
    }
    assert_eq!(wrong, 0, "verdicts or times are wrong");
}
