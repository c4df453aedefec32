//! The parameters of a controller that a tuner may change.

use crate::controllers::kind::Kind;
use crate::gains::Gains;

/// A positive parameter of a controller.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its field in a profile, below `gains`.
    pub name: &'static str,
    /// How a smaller value changes the speed of the loop.
    effect: Effect,
    field: fn(&mut Gains) -> &mut f64,
}

/// The effect of a smaller value on a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Slower,
    Faster,
    /// It takes from one direction what it gives to the other.
    Neither,
}

const fn faster(name: &'static str, field: fn(&mut Gains) -> &mut f64) -> Parameter {
    Parameter { name, effect: Effect::Slower, field }
}

const fn slower(name: &'static str, field: fn(&mut Gains) -> &mut f64) -> Parameter {
    Parameter { name, effect: Effect::Faster, field }
}

const PROPORTIONAL: Parameter = faster("proportional", |gains| &mut gains.proportional);
const PID: [Parameter; 3] = [
    faster("pid.proportional", |gains| &mut gains.pid.proportional),
    faster("pid.integral", |gains| &mut gains.pid.integral),
    faster("pid.derivative", |gains| &mut gains.pid.derivative),
];
const COUPLED: [Parameter; 4] = [
    PROPORTIONAL,
    faster("cross_coupling.proportional", |gains| &mut gains.cross_coupling.proportional),
    faster("cross_coupling.integral", |gains| &mut gains.cross_coupling.integral),
    faster("cross_coupling.derivative", |gains| &mut gains.cross_coupling.derivative),
];
const QUICKNESS: [Parameter; 1] = [faster("design.quickness", |gains| &mut gains.design.quickness)];
const INDEX: [Parameter; 3] = [
    faster("design.index.integral", |gains| &mut gains.design.index.integral),
    slower("design.index.effort", |gains| &mut gains.design.index.effort),
    faster("design.contour", |gains| &mut gains.design.contour),
];
const PREDICTIVE: [Parameter; 1] =
    [slower("design.predictive_effort", |gains| &mut gains.design.predictive_effort)];
const CONTOURING: [Parameter; 5] = [
    faster("design.contouring.bandwidth", |gains| &mut gains.design.contouring.bandwidth),
    faster("design.contouring.changes", |gains| &mut gains.design.contouring.changes),
    Parameter {
        name: "design.contouring.lag",
        effect: Effect::Neither,
        field: |gains| &mut gains.design.contouring.lag,
    },
    faster("design.contouring.observer", |gains| &mut gains.design.contouring.observer),
    faster("design.contouring.load", |gains| &mut gains.design.contouring.load),
];

impl Parameter {
    /// The parameters of a controller. Those of the selection are those of its choice.
    #[must_use]
    pub fn of(kind: Kind) -> &'static [Self] {
        match kind {
            Kind::P
            | Kind::ExactInverse
            | Kind::DriveFeedforward
            | Kind::Zpetc
            | Kind::Ikf
            | Kind::AdaptiveZpetc
            | Kind::Matching
            | Kind::Repetitive => std::slice::from_ref(&PROPORTIONAL),
            Kind::Pid | Kind::PidB | Kind::PidC | Kind::PidD | Kind::PidCorners | Kind::PidZpetc => &PID,
            Kind::StateFeedback => &QUICKNESS,
            Kind::Ccc | Kind::CccFeedforward | Kind::CccExact => &COUPLED,
            Kind::Lq => INDEX.split_at(2).0,
            Kind::OptimalCcc => &INDEX,
            Kind::Gpc => &PREDICTIVE,
            Kind::Selection => &[],
            Kind::Contouring => &CONTOURING,
        }
    }

    /// The value.
    #[must_use]
    pub fn value(&self, gains: &Gains) -> f64 {
        let mut gains = *gains;
        *(self.field)(&mut gains)
    }

    /// `gains` with this value multiplied by `factor`, or a thousandth of a unit where it was 0.
    #[must_use]
    pub fn times(&self, gains: &Gains, factor: f64) -> Gains {
        let mut gains = *gains;
        let value = (self.field)(&mut gains);
        *value = if *value == 0.0 { 1e-3 } else { *value * factor };
        gains
    }

    /// `gains` with this value changed by `factor` to the slower side.
    #[must_use]
    pub fn slowed(&self, gains: &Gains, factor: f64) -> Gains {
        match self.effect {
            Effect::Slower => self.times(gains, 1.0 / factor),
            Effect::Faster => self.times(gains, factor),
            Effect::Neither => *gains,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::DriveProfile;

    /// The name of a parameter is its field in a profile, and each value is checked when a profile is read.
    #[test]
    fn parameters_are_fields_of_a_profile() {
        let gains = DriveProfile::simulated().unwrap().gains;
        for kind in Kind::ALL {
            for parameter in Parameter::of(kind) {
                let twice = parameter.times(&gains, 2.0);
                assert!((parameter.value(&twice) / parameter.value(&gains) - 2.0).abs() < 1e-12);
                let table = toml::Value::try_from(twice).unwrap();
                let field = parameter.name.split('.').fold(&table, |table, name| &table[name]);
                assert_eq!(field.as_float(), Some(parameter.value(&twice)), "{}", parameter.name);
                let full = format!("gains.{}", parameter.name);
                assert!(twice.figures().iter().any(|each| each.field == full), "{full} is not checked");
            }
        }
    }
}
