//! States on which a feature, or the comparison itself, once failed.

use super::compare::{Judgement, compare};
use super::feature::{Feature, State};
use carom::Vector;
use carom::physics::overlap::Side;

fn is_not_wrong(state: &State) {
    let comparison = compare(state);
    assert!(!matches!(comparison.judgement, Judgement::Wrong(_)), "{comparison:?}");
}

#[test]
fn a_line_that_is_grazed_twice_may_be_met_the_second_time() {
    is_not_wrong(&State {
        feature: Feature::Line(
            Vector::new(-0.5109392802507435, 0.3383123928556952, -0.7902441247722793),
            Side::Positive,
        ),
        position: Vector::new(11.833935345130339, 69.32502455566467, 23.960512794753946),
        velocity: Vector::new(-9.240067011709147, -61.367788349474026, -21.409040881533883),
        acceleration: Vector::new(3.884373234638772, 27.245658636065713, 9.152697092749028),
        contact: 1.3031053409227717,
    });
}
