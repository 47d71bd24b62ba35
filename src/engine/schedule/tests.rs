use super::*;
use proptest::prelude::*;

struct Times(Vec<f64>, Vec<u32>);

impl Times {
    fn new(times: &[f64]) -> Self {
        Self(times.to_vec(), vec![0; times.len()])
    }
}

impl Pending for Times {
    fn entry(&self, particle: u32) -> QueueEntry {
        QueueEntry { time: self.0[particle as usize], particle, tie_order: self.1[particle as usize] }
    }

    fn rank(&self, particle: u32) -> u64 {
        u64::from(u32::MAX - particle)
    }

    fn prefetch(&self, _: u32) {}
}

fn entry(time: f64, particle: u32) -> QueueEntry {
    QueueEntry { time, particle, tie_order: 0 }
}

#[test]
fn power_of_two_rounds_down_exactly() {
    assert_eq!(power_of_two(1.0), 1.0);
    assert_eq!(power_of_two(1.0_f64.next_down()), 0.5);
    assert_eq!(power_of_two(1000.0), 512.0);
    assert!(power_of_two(0.0) > 0.0);
}

#[test]
fn bucket_width_shrinks_with_the_number_of_due_events() {
    let [few, many] = [1, 1 << 14].map(|due| EventQueue::new(1 << 14, due, 1.0));
    assert_eq!(few.buckets.count(), many.buckets.count());
    assert_eq!(few.width, 64.0);
    assert_eq!(many.width, 64.0 / f64::from(1 << 14));
}

#[test]
fn ties_come_out_by_tie_order_then_by_rank() {
    for time in [0.5, 300.0] {
        let mut queue = EventQueue::new(1024, 1024, 64.0);
        let mut pending = Times::new(&[time; 10]);
        pending.1[5] = 1;
        for particle in [5, 9, 3] {
            queue.push(pending.entry(particle), &pending);
        }
        let mut order = Vec::new();
        while let Some(next) = queue.peek(f64::INFINITY, &pending) {
            queue.pop();
            order.push(next.particle);
        }
        assert_eq!(order, [9, 3, 5]);
    }
}

#[test]
fn opened_bucket_uses_current_wake_times() {
    let mut queue = EventQueue::new(1024, 1024, 64.0);
    let mut pending = Times::new(&[100.0, 200.0, 300.0]);
    for (particle, time) in [(0, 100.0), (1, 200.0), (2, 300.0), (1, 200.0)] {
        queue.push(entry(time, particle), &pending);
    }
    pending.0[0] = 250.0;
    queue.push(entry(250.0, 0), &pending);
    let mut order = Vec::new();
    while let Some(next) = queue.peek(f64::INFINITY, &pending) {
        queue.pop();
        order.push((next.time, next.particle));
    }
    assert_eq!(order, [(200.0, 1), (250.0, 0), (300.0, 2)]);
}

#[test]
fn a_crowded_epoch_ends_with_its_bucket_and_the_next_one_is_shorter() {
    let mut queue = EventQueue::new(512, 512, 64.0);
    let (span, width) = (queue.span(), queue.width);
    assert_eq!(span, 64.0 * width);
    let most = 4 * 64 * 64;
    let pending = Times::new(&[0.0; 2]);
    for k in 0..=most {
        let time = width * f64::from(k) / f64::from(most + 1);
        queue.push(entry(time, 0), &pending);
        assert_eq!(queue.peek(f64::INFINITY, &pending), Some(entry(time, 0)));
        queue.pop();
    }
    queue.push(entry(1.5 * width, 1), &pending);
    assert_eq!(queue.peek(f64::INFINITY, &pending), None);
    assert_eq!(queue.reached(), width);
    queue.restart();
    assert_eq!(queue.span(), span / 512.0);
    queue.push(entry(0.5 * queue.width, 1), &pending);
    assert!(queue.peek(f64::INFINITY, &pending).is_some());
}

#[test]
fn a_queue_looks_no_further_than_the_bucket_of_the_limit() {
    let mut queue = EventQueue::new(512, 512, 64.0);
    let width = queue.width;
    let pending = Times::new(&[40.5 * width; 2]);
    queue.push(entry(40.5 * width, 0), &pending);
    assert_eq!(queue.peek(10.5 * width, &pending), None);
    assert_eq!(queue.reached(), 11.0 * width);
    assert_eq!(queue.peek((20.0 * width).next_down(), &pending), None);
    assert_eq!(queue.reached(), 20.0 * width);
    assert_eq!(queue.peek(20.0 * width, &pending), None);
    assert_eq!(queue.reached(), 21.0 * width);
    assert_eq!(queue.peek(40.0 * width, &pending), Some(entry(40.5 * width, 0)));
}

#[test]
fn a_queue_that_resumes_beyond_its_horizon_has_come_to_its_end() {
    let mut queue = EventQueue::new(512, 512, 64.0);
    let pending = Times::new(&[0.0; 2]);
    queue.resume(1e6 * queue.span(), 3);
    assert_eq!((queue.reached(), queue.steps()), (queue.span(), 3));
    assert_eq!(queue.peek(f64::INFINITY, &pending), None);
}

proptest! {
    #[test]
    fn entries_come_out_in_order_whenever_they_came_in(
        times in prop::collection::vec(0.0..8.0_f64, 1..200),
        median in 1e-3..1e3_f64,
    ) {
        let mut queue = EventQueue::new(times.len(), times.len(), median);
        let (early, later) = times.split_at(times.len() / 2);
        let mut pending = Times::new(&times);
        for (k, &time) in (0..).zip(early) {
            queue.push(entry(time, k), &pending);
        }
        let mut expected: Vec<f64> = early.iter().copied().filter(|t| *t < queue.span()).collect();
        let mut now = 0.0;
        let mut found = Vec::new();
        let mut particle = early.len();
        while let Some(next) = queue.peek(f64::INFINITY, &pending) {
            queue.pop();
            prop_assert!(next.time >= now);
            now = next.time;
            found.push(now);
            if let Some(dt) = later.get(particle - early.len()) {
                let time = now + dt;
                pending.0[particle] = time;
                queue.push(entry(time, u32::try_from(particle).unwrap()), &pending);
                if time < queue.span() { expected.push(time); }
                particle += 1;
            }
        }
        expected.sort_by(f64::total_cmp);
        prop_assert_eq!(found, expected);
    }
}
