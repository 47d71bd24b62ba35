//! Inelastic spheres.

/// Haff's law of a freely cooling granular gas: `T = T_0 / (1 + t / tau)^2`. The time `tau` is [`haff_time`].
///
/// Haff, J. Fluid Mech. 134, 401 (1983), [doi:10.1017/S0022112083003419](https://doi.org/10.1017/S0022112083003419).
#[must_use]
pub fn haff_temperature(start: f64, time: f64, haff_time: f64) -> f64 {
    let slowed = 1.0 + time / haff_time;
    start / (slowed * slowed)
}

/// The time `tau` in Haff's law for smooth spheres `[time]`: `tau = 6 / ((1 - e^2) G_0)`, where `e` is the restitution
/// and `G_0` is the initial collision rate per particle, for small `1 - e^2`. Each contact removes `(1 - e^2) T / 2`
/// from a pair on average, so `dT/dt = -(1 - e^2) G T / 3`. The rate `G` is proportional to `sqrt(T)`.
#[must_use]
pub fn haff_time(restitution: f64, collision_rate: f64) -> f64 {
    6.0 / ((1.0 - restitution * restitution) * collision_rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gas_cools_at_the_rate_of_its_contacts() {
        let (e, rate) = (0.9, 3.0);
        let tau = haff_time(e, rate);
        let dt = 1e-6 * tau;
        let slope = (haff_temperature(2.0, dt, tau) - 2.0) / dt;
        // The finite step has a relative error of 1.5e-6.
        assert!((slope / (-(1.0 - e * e) * rate * 2.0 / 3.0) - 1.0).abs() < 2e-6);
        assert_eq!(haff_temperature(2.0, tau, tau), 0.5);
    }
}
