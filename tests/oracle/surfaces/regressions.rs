//! Regression tests of contacts with surfaces. For each state, the prediction or its test was once wrong.

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

/// Each side is given by a direction into the face and the position of the sphere relative to an end of the side.
fn face(normal: [f64; 3], sides: [[[f64; 3]; 2]; 3], motion: [[f64; 3]; 3], contact: f64) -> State {
    let sides = sides.map(|[inward, from]| (Vector::from(inward), Vector::from(from)));
    let [position, velocity, acceleration] = motion.map(Vector::from);
    State { feature: Feature::Face(Vector::from(normal), sides), position, velocity, acceleration, contact }
}

#[test]
fn a_foot_comes_onto_a_face_at_its_corner() {
    // The sphere passes two sides of the face at the same time. With rounding, the sphere was always outside one of the
    // two sides, and the event was missed.
    is_not_wrong(&face(
        [-0.7142794160655317, 0.603633676388236, 0.35416281639255304],
        [
            [
                [0.41209238930566633, -0.04626524038648073, 0.9099666973072853],
                [-2.165126207620053, -1.0546318886806718, 0.4672665967528073],
            ],
            [
                [0.031145089967072093, 0.5329625365686214, -0.8455654427572616],
                [-1.8035379746539728, -0.5458658542748089, 0.32938289578130625],
            ],
            [
                [-0.6487508587709361, -0.381244725104983, -0.6586158082096107],
                [-2.054009817498451, -0.7582823473363678, 0.18627037614461167],
            ],
        ],
        [
            [-2.18054188651163, -0.5404099237623239, -0.4402617557547615],
            [1.3878439659829112, 1.0948420091657438, -0.22879540271330306],
            [-0.5003987811889223, -0.6631547795397268, 0.18838023542279456],
        ],
        0.5424522460844553,
    ));
}

#[test]
fn a_face_is_met_where_it_is_thinner_than_an_ulp_of_the_time() {
    // The sphere is thrown up from the face and falls back at t = 1. With rounding, the contact and the height zero
    // have the same time.
    let sides = [[[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]; 3];
    let motion = [[0.0; 3], [1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]];
    let state = face([1.0, 0.0, 0.0], sides, motion, 1e-18);
    assert_eq!(state.ask(), Some(1.0));
    is_not_wrong(&state);
}

#[test]
fn a_face_lost_in_the_rounding_of_heights_may_be_met() {
    // The sphere returns to a face of size 1 along a parabola of size 1e18.
    let from = [-3.878081564062907e17, -9.951285773022263e17, 1.254433621068594e17];
    is_not_wrong(&face(
        [-0.6794200280422069, -0.5194572251688314, -0.5182206255206607],
        [
            [[-0.21729838598323084, -0.5321365551291, 0.8182982941106606], from],
            [[0.10489645414915913, 0.6302465157167895, -0.769276324433412], from],
            [[0.26873126799336744, -0.8333530016016845, 0.48301788820305597], from],
        ],
        [
            from,
            [639781906.2664896, 1641701567.255512, -206948698.7610511],
            [-0.5277363057278694, -1.3541888442374925, 0.17070558058866947],
        ],
        0.9914734222010659,
    ));
}
