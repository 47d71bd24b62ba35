//! Writes the table of the long run, `benches/results/detection.md`.

use crate::detection::Algorithm;
use crate::tally::{Tally, spread};
use std::fmt::Write;
use std::process::Command;

const COMMAND: &str = "CAROM_ORACLE=50000 cargo test --release --test oracle -- --nocapture";

const EXPLANATION: &str = "\
The oracle (`tests/oracle`) applies the paper's rule in exact arithmetic. A state counts as *within rounding* if two \
conditions hold. First, Carom and the oracle give different verdicts, or their times differ by more than the bound. Second, there \
is a polynomial for which the oracle gives Carom's answer, and whose coefficients differ from the exact coefficients by no \
more than their rounding. *Error* is the error of Carom's time, for events in the future on which Carom and the oracle \
agree. *Allowed* is the shift of the exact root that the rounding of the coefficients of f and of its evaluation may cause, \
plus one ulp of the time. The bound on *error / allowed* is 3 (4 for Algorithm 1); `tests/oracle/compare.rs` derives it.\n";

pub fn page(totals: &mut [(Algorithm, Tally)], families: &str, seed: u64) -> String {
    let mut page = format!(
        "# Event detection against the exact oracle\n\n{}, {}, {}, seed {seed}. Made by\n\n    {COMMAND}\n\n",
        printed_by("date", &["-u", "+%Y-%m-%d"]),
        std::env::consts::ARCH.replace('_', "-"),
        printed_by("rustc", &["--version"]),
    );
    page += EXPLANATION;
    verdicts(&mut page, totals);
    let mut bracketing: Vec<_> = totals.iter_mut().filter(|(a, _)| a.takes_acceleration() == Some(true)).collect();
    evaluations(&mut page, &mut bracketing);
    closed_forms(&mut page, &mut bracketing);
    page += "\n## By family\n\n\
        | algorithm | family | cases | events after now | wrong | within rounding | median error [ulp] | \
        worst error / allowed |\n|---|---|---|---|---|---|---|---|\n";
    page + families
}

fn verdicts(page: &mut String, totals: &mut [(Algorithm, Tally)]) {
    *page += "\n## Verdicts and times\n\n\
        | algorithm | cases | events after now | wrong | within rounding | error [ulp]: median | 99.9 % | worst | \
        error / allowed: median | 99.9 % | worst |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (algorithm, total) in totals {
        let (cases, later, wrong, within) = (total.cases, total.events_later, total.wrong_count, total.within_rounding);
        let [errors, ratios] = [spread(&mut total.errors), spread(&mut total.ratios)];
        let _ = writeln!(
            page,
            "| {} | {cases} | {later} | {wrong} | {within} | {} | {} |",
            algorithm.name(),
            columns(errors),
            columns(ratios)
        );
    }
}

fn evaluations(page: &mut String, totals: &mut [&mut (Algorithm, Tally)]) {
    *page += "\n## Evaluations of f per bracketed root\n\n\
        | algorithm | roots | Carom: median | 99.9 % | worst | bisection: median | 99.9 % | worst | \
        Brent (`roots`): median | 99.9 % | worst |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (algorithm, total) in totals {
        let e = &mut total.evaluations;
        let count = e.ours.len();
        let spreads = [&mut e.ours, &mut e.bisection, &mut e.brent].map(|values| columns(spread(values)));
        let _ = writeln!(page, "| {} | {count} | {} |", algorithm.name(), spreads.join(" | "));
    }
}

fn closed_forms(page: &mut String, totals: &mut [&mut (Algorithm, Tally)]) {
    *page += "\n## Closed forms of the crate `roots`\n\n\
        Of all roots that the closed form returns, the comparison uses the root nearest to the exact one. The table gives \
        the errors of roots within one part in 1000 of the exact root.\n\n\
        | polynomial, algorithm | roots | relative error: median | 99.9 % | worst found | above 1e-6 | missed |\n\
        |---|---|---|---|---|---|---|\n";
    for (algorithm, total) in totals {
        closed_form_row(page, "f", *algorithm, &mut total.evaluations.quartic);
        closed_form_row(page, "f'", *algorithm, &mut total.evaluations.cubic);
    }
}

/// Relative error above which a closed form has missed the root.
const MISSED: f64 = 1e-3;

fn closed_form_row(page: &mut String, polynomial: &str, algorithm: Algorithm, errors: &mut [f64]) {
    let (count, missed) = (errors.len(), errors.iter().filter(|&&e| e > MISSED).count());
    let poor = errors.iter().filter(|&&e| e > 1e-6).count();
    let mut found: Vec<_> = errors.iter().copied().filter(|&e| e <= MISSED).collect();
    let percent = |part: usize| 100.0 * part as f64 / count.max(1) as f64;
    let _ = writeln!(
        page,
        "| {polynomial}, {} | {count} | {} | {:.2} % | {:.2} % |",
        algorithm.name(),
        columns(spread(&mut found)),
        percent(poor),
        percent(missed)
    );
}

pub fn family_row(table: &mut String, algorithm: Algorithm, family: &str, tally: &mut Tally) {
    let median = number(spread(&mut tally.errors)[0]);
    let worst = number(spread(&mut tally.ratios)[2]);
    let _ = writeln!(
        table,
        "| {} | {family} | {} | {} | {} | {} | {median} | {worst} |",
        algorithm.name(),
        tally.cases,
        tally.events_later,
        tally.wrong_count,
        tally.within_rounding
    );
}

fn columns(values: [f64; 3]) -> String {
    values.map(number).join(" | ")
}

fn number(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        x if !(1e-3..1e4).contains(&x) => format!("{x:.1e}"),
        x if x == x.round() => format!("{x}"),
        x => format!("{x:.2}"),
    }
}

fn printed_by(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    output.map_or_else(|_| program.into(), |output| String::from_utf8_lossy(&output.stdout).trim().into())
}
