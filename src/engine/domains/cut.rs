//! A system that is cut into domains, and the execution of a window.

use super::domain::Domain;
use super::exchange::{Compared, Published, Transfer};
use super::outcome::Outcome;
use super::regions::Regions;
use super::team::Team;
use super::work::DomainWork;
use crate::engine::clock::Moved;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::parts::Engine;
use crate::engine::sources::andersen::Andersen;
use std::time::Instant;

#[derive(Debug, Clone)]
pub struct Cut<const FALLING: bool, const TABLE: bool> {
    pub regions: Regions,
    pub domains: Vec<Domain<FALLING, TABLE>>,
    /// Simulated time that all domains have reached, relative to the epoch.
    pub now: f64,
    /// Time of the last step, or the time limit if the run has reached it. The time is counted from the epoch.
    pub latest: f64,
    pub steps: u64,
    /// True if the single engine has the current state.
    pub is_settled: bool,
    /// True if the single engine has all that it needs to continue.
    pub is_complete: bool,
    /// True until the first window after the cut is accepted.
    pub is_fresh: bool,
    /// Results of the last comparison, only for the domains of this process.
    pub compared: Vec<Compared>,
    pub outcomes: Vec<Outcome>,
    /// The heat bath before this window, for a rollback.
    pub bath: Option<Andersen>,
}

pub enum End {
    Agreed,
    /// A particle and its copy differ in a step at this time.
    Difference(f64),
    /// A domain cannot continue alone at this time.
    Uncovered(f64),
}

impl<const FALLING: bool, const TABLE: bool> Cut<FALLING, TABLE> {
    /// Draws the collisions with the heat bath for a window, and passes them to the domains that hold the particles.
    pub fn draw_collisions(&mut self, whole: &mut Engine<FALLING, TABLE>, stop: f64) {
        self.bath.clone_from(&whole.sources.andersen);
        if self.bath.is_none() {
            return;
        }
        let mut bath = whole.sources.andersen.take();
        let collisions = whole.collisions_until(&mut bath, stop);
        whole.put_bath(bath);
        for domain in &mut self.domains {
            let of_domain = collisions.iter().rev().map(|collision| {
                let number = whole.state.numbers[collision.id];
                (domain.here[number as usize], *collision)
            });
            domain.collisions = of_domain.filter(|(here, _)| *here != NO_PARTICLE).collect();
        }
    }

    pub fn run(&mut self, team: &Team, stop: f64, is_observed: bool, work: &mut DomainWork) -> End {
        team.within(|| self.run_and_compare(team, stop, is_observed, work))
    }

    fn run_and_compare(&mut self, team: &Team, stop: f64, is_observed: bool, work: &mut DomainWork) -> End {
        let regions = &self.regions;
        let begin = Instant::now();
        let took = team.each(self.domains.iter_mut().collect(), |domain| {
            let begin = Instant::now();
            domain.begin_window();
            domain.run(regions, stop, is_observed);
            begin.elapsed()
        });
        work.simulate(begin.elapsed(), &took, team.busy_threads(took.len()));
        let begin = Instant::now();
        let earliest = |times: Vec<Option<f64>>| times.into_iter().flatten().min_by(f64::total_cmp);
        let trouble = team.all(self.domains.iter().map(|domain| domain.trouble).collect());
        if team.has_others() {
            work.waiting += begin.elapsed();
        }
        if let Some(time) = earliest(trouble) {
            return End::Uncovered(time);
        }
        let begin = Instant::now();
        let reports = team.each(self.domains.iter().collect(), |domain| domain.reports(team.domains()));
        let reports = team.deliver(reports.into_iter().flatten().collect(), |report| 1 << report.to);
        self.compared = team.each(self.domains.iter().collect(), |domain| domain.compare(regions, &reports));
        let domains = self.domains.iter_mut().zip(&self.compared);
        self.outcomes = team.all(domains.map(|(domain, compared)| domain.outcome(compared.difference)).collect());
        work.comparing += begin.elapsed();
        let differences = self.outcomes.iter().map(|outcome| outcome.difference).collect();
        earliest(differences).map_or(End::Agreed, End::Difference)
    }

    pub fn undo(&mut self, whole: &mut Engine<FALLING, TABLE>, team: &Team) {
        if self.bath.is_some() {
            whole.sources.andersen.clone_from(&self.bath);
            whole.schedule_global();
        }
        let now = self.now;
        team.each(self.domains.iter_mut().collect(), |domain| domain.undo(now));
    }

    /// Brings all copies up to date.
    pub fn exchange(&mut self, team: &Team) {
        team.within(|| self.refresh(team));
    }

    fn refresh(&mut self, team: &Team) {
        let with_compared = self.domains.iter().zip(&self.compared);
        let published = team.each(with_compared.collect(), |(domain, compared)| domain.publish(&compared.to_publish));
        let published: Vec<Published> = team.deliver(published.into_iter().flatten().collect(), |one| one.to);
        let transfers = self.compared.iter_mut().flat_map(|compared| std::mem::take(&mut compared.transfers)).collect();
        let transfers: Vec<Transfer> = team.deliver(transfers, |transfer| transfer.known_to);
        team.each(self.domains.iter_mut().collect(), |domain| domain.refresh(&published, &transfers));
    }

    pub fn follow(&mut self, whole: &Engine<FALLING, TABLE>, moved: Moved, team: &Team) {
        let to_publish = team.each(self.domains.iter_mut().collect(), |domain| domain.follow(whole, moved));
        self.compared =
            to_publish.into_iter().map(|to_publish| Compared { to_publish, ..Compared::default() }).collect();
        self.exchange(team);
    }
}
