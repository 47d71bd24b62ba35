use super::problem::{Pair, Problem};
use super::{paper, textbook};
use carom::physics::detection::{accelerated, inertial};

pub struct Method {
    pub name: &'static str,
    pub ask: fn(&Pair) -> Option<f64>,
    /// Whether a call takes thousands of evaluations of `f`. Slow methods are timed with fewer calls.
    pub is_slow: bool,
}

fn quick(name: &'static str, ask: fn(&Pair) -> Option<f64>) -> Method {
    Method { name, ask, is_slow: false }
}

/// Methods that solve a problem. The paper uses bisection only for accelerated pairs, in Algorithms 4 to 6.
pub fn of(problem: Problem) -> Vec<Method> {
    let mut methods = if problem.is_accelerated {
        vec![
            quick("closed-form quartic", textbook::closed_form_quartic),
            quick("paper; bisection to 1e-4", |pair| paper::next_event(pair, 1e-4)),
            quick("paper; bisection to 1e-8", |pair| paper::next_event(pair, 1e-8)),
            quick("paper; bisection to 1e-12", |pair| paper::next_event(pair, 1e-12)),
            quick("Carom", |pair| accelerated::next_event(&pair.quartic, pair.side)),
        ]
    } else {
        vec![
            quick("textbook quadratic", textbook::quadratic),
            quick("Carom", |pair| inertial::next_event(&pair.quadratic, pair.side)),
        ]
    };
    methods.push(quick("Newton from now", textbook::newton));
    methods.push(Method { name: "steps of 0.1", ask: |pair| textbook::scan(pair, 0.1), is_slow: true });
    methods.push(Method { name: "steps of 0.01", ask: |pair| textbook::scan(pair, 0.01), is_slow: true });
    methods
}
