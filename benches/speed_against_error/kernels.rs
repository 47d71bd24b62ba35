//! Compares detection functions: time per call against error of the returned time. The exact oracle gives the error.

mod judge;
mod methods;
mod paper;
mod problem;
mod states;
mod textbook;

use super::Outcome;
use super::plot::{Panel, Series, draw};
use super::sheet::{Sheet, number};
use judge::{Judgement, Truth};
use methods::Method;
use problem::{Pair, Problem};
use states::Class;
use std::hint::black_box;
use std::time::Instant;

const STATES: usize = 1_000;

/// Number of passes over the states. The fastest pass is reported, because other programs can only slow down a pass.
const PASSES: usize = 9;

/// Minimum number of calls in a pass, so that the resolution of the clock does not matter.
const CALLS: usize = 20_000;

const SHEET: &str = "kernels";

pub fn measure() -> Outcome {
    let mut sheet = Sheet::new(
        SHEET,
        &[
            "problem",
            "states",
            "method",
            "ns per call",
            "median error",
            "worst error",
            "worst / allowed",
            "missed",
            "invented",
            "within rounding",
        ],
    );
    for problem in Problem::ALL {
        for class in [Class::Ordinary, Class::Hard] {
            let pairs = states::pairs(problem, class, STATES);
            let truths: Vec<Truth> = pairs.iter().map(Truth::new).collect();
            for method in methods::of(problem) {
                sheet.push(row(problem, class, &method, &pairs, &truths))?;
            }
        }
    }
    Ok(())
}

fn row(problem: Problem, class: Class, method: &Method, pairs: &[Pair], truths: &[Truth]) -> Vec<String> {
    let judgements: Vec<_> = pairs.iter().zip(truths).map(|(pair, truth)| truth.judge((method.ask)(pair))).collect();
    let count = |kind: Judgement| judgements.iter().filter(|&&judgement| judgement == kind).count().to_string();
    let mut errors: Vec<[f64; 2]> = Vec::new();
    errors.extend(judgements.iter().filter_map(|judgement| match judgement {
        Judgement::Time { relative, of_allowed } => Some([*relative, *of_allowed]),
        _ => None,
    }));
    errors.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let median = errors.get(errors.len() / 2).map_or(f64::NAN, |error| error[0]);
    let worst = |k: usize| errors.iter().map(|error| error[k]).fold(f64::NAN, f64::max);
    vec![
        problem.name().to_owned(),
        class.name().to_owned(),
        method.name.to_owned(),
        number(nanoseconds(method, pairs)),
        number(median),
        number(worst(0)),
        number(worst(1)),
        count(Judgement::Missed),
        count(Judgement::Invented),
        count(Judgement::WithinRounding),
    ]
}

fn nanoseconds(method: &Method, pairs: &[Pair]) -> f64 {
    let repeats = if method.is_slow { 1 } else { CALLS.div_ceil(pairs.len()) };
    let pass = || {
        let start = Instant::now();
        for _ in 0..repeats {
            for pair in pairs {
                black_box((method.ask)(black_box(pair)));
            }
        }
        start.elapsed().as_secs_f64() * 1e9 / (repeats * pairs.len()) as f64
    };
    let passes = if method.is_slow { 1 } else { PASSES };
    (0..passes).map(|_| pass()).fold(f64::INFINITY, f64::min)
}

const EXPLANATION: &str = "
## Kernels

One call takes the coefficients of an overlap function and returns the time of the next event, or none. An oracle that computes with
integers decides which answer is right. *Error* is the relative error of a returned time in the future, if it belongs to the right event
(closer than 1 part in 100). *Allowed* is the largest shift of the exact root that rounding of the coefficients and of `f` may cause, plus
one ulp. If an answer is wrong, but right for coefficients that differ by no more than their rounding, it counts as *within rounding*. In
all other cases, an event that the method does not find is *missed*. An event that the method returns is *invented* if it does not take
place, or takes place later. Each problem has 1,000 ordinary and 1,000 hard states, from a fixed seed. Hard states are pairs exactly in
contact, pairs one floating-point number from contact, grazing pairs, overlapping pairs and, with acceleration, pairs with tiny
accelerations.

*What it shows*: the cost of one call of a detection function, and how reliable the answer is in states in which many codes fail. In
ordinary states most methods are good enough. The methods differ in the hard states. A missed event lets particles pass through each other.
An invented event changes nothing, but is predicted again and again. If a relative error in the hard states is large, the root is badly
conditioned: compare *worst / allowed*.

*What it does not show*: how often a simulation has hard states (dense systems, sticky particles and heaps have them all the time); the cost
of a detection function inside a loop that is limited by memory access; methods with an additional remedy, such as skipping the pair that
has just collided. In this comparison, the paper's algorithms take the roots of `f'` from the closed-form solver of the crate `roots`, and
bisect down to a relative width. A better cubic solver would improve these algorithms. The methods with fixed steps stop at a time of 100.

";

pub fn describe(text: &mut String) -> Outcome {
    let Some(sheet) = Sheet::read(SHEET) else { return Ok(()) };
    *text += EXPLANATION;
    *text += &format!("{}\n\n", sheet.provenance);
    let mut rows = Vec::new();
    for problem in sheet.values("problem") {
        let of_problem = sheet.with("problem", &problem);
        *text += &format!("{}\n", of_problem.markdown());
        rows.push(vec![errors(&problem, &of_problem), failures(&problem, &of_problem)]);
    }
    *text += "![Time per call against the worst error and against wrong verdicts](speed_against_error/kernels.svg)\n";
    draw(SHEET, &rows)
}

fn errors(problem: &str, rows: &Sheet) -> Panel {
    Panel {
        title: format!("{problem}: ordinary states"),
        x: "time per call [ns]".to_owned(),
        y: "worst relative error of the time".to_owned(),
        series: series(&rows.with("states", Class::Ordinary.name()), |row| row.numbers("worst error")[0]),
    }
}

/// Zero is drawn at this value on a logarithmic axis.
const NO_FAILURE: f64 = 0.5 / STATES as f64;

fn failures(problem: &str, rows: &Sheet) -> Panel {
    let share = |row: &Sheet| (row.numbers("missed")[0] + row.numbers("invented")[0]) / STATES as f64;
    Panel {
        title: format!("{problem}: hard states"),
        x: "time per call [ns]".to_owned(),
        y: format!("share of wrong verdicts (0 is drawn at {NO_FAILURE})"),
        series: series(&rows.with("states", Class::Hard.name()), |row| share(row).max(NO_FAILURE)),
    }
}

fn series(rows: &Sheet, value: impl Fn(&Sheet) -> f64) -> Vec<Series> {
    let of = |method: String| {
        let row = rows.with("method", &method);
        Series { name: method, points: vec![(row.numbers("ns per call")[0], value(&row))], has_line: false }
    };
    rows.values("method").into_iter().map(of).collect()
}
