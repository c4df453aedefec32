//! The circular test: how far a machine leaves a circle (ISO 230-4), measured by a ballbar or a grid encoder.

mod picture;

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use crate::Axes;
use crate::number_table::{NumberTable, TableError};

/// The result of a circular test, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct CircularTest {
    /// Nominal radius of the circle.
    pub radius_mm: f64,
    /// The points, about the centre, in the order of the file.
    pub points_mm: Vec<Axes>,
    /// Centre of the circle of least squares: how the instrument was set up.
    pub centre_mm: Axes,
    /// Largest and smallest radial deviation from the nominal circle about that centre: F(max) and F(min).
    pub deviations_mm: [f64; 2],
    /// Directions of the two from the centre, degrees.
    pub directions_deg: [f64; 2],
    /// RMS of the radial deviation.
    pub rms_mm: f64,
}

/// Reasons for which a circular test gives no contour error.
#[derive(Debug, Error)]
pub enum BallbarError {
    /// The file is not a table of numbers.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The points are not a full circle.
    #[error(
        "{name}: there is no point over {gap_deg:.0}° of the circle. Measure all of it, at least a point each \
         {MOST_GAP_DEG}°."
    )]
    Gap {
        /// The file.
        name: String,
        /// The largest angle between two neighbours, degrees.
        gap_deg: f64,
    },
    /// The points are far from the circle.
    #[error(
        "{name}: a point is {off_mm:.3} mm off the circle of {radius_mm} mm. Check the radius, and that the columns \
         are in mm."
    )]
    Far {
        /// The file.
        name: String,
        /// The distance, mm.
        off_mm: f64,
        /// The nominal radius, mm.
        radius_mm: f64,
    },
}

/// Largest angle between two neighbours on the circle, degrees.
const MOST_GAP_DEG: f64 = 10.0;
/// Largest deviation, as a share of the radius.
const MOST_OFF: f64 = 0.1;
/// Number of Gauss-Newton steps for the circle.
const STEPS: u32 = 20;

impl CircularTest {
    /// Reads the points of a test of a circle with this radius, mm. The columns are `x_mm` and `y_mm`, or `angle_deg`
    /// and `radius_mm`. Both directions may stand in one file.
    ///
    /// # Errors
    /// [`BallbarError`] if the points are not such a circle.
    pub fn load(path: &Path, radius_mm: f64) -> Result<Self, BallbarError> {
        Self::of(&path.display().to_string(), &NumberTable::load(path)?, radius_mm)
    }

    /// The test of a table. Messages refer to it by `name`.
    ///
    /// # Errors
    /// [`BallbarError`] if the points are not such a circle.
    pub fn of(name: &str, table: &NumberTable, radius_mm: f64) -> Result<Self, BallbarError> {
        let has = |names: [&str; 2]| names.iter().all(|name| table.column(name).is_some());
        let points: Vec<Axes> = if has(["x_mm", "y_mm"]) {
            let [x, y] = [table.numbers("x_mm")?, table.numbers("y_mm")?];
            x.into_iter().zip(y).map(|(x, y)| Axes::new(x, y)).collect()
        } else if has(["angle_deg", "radius_mm"]) {
            let [angle, radius] = [table.numbers("angle_deg")?, table.numbers("radius_mm")?];
            let point = |(angle, radius): (f64, f64)| {
                let (sin, cos) = angle.to_radians().sin_cos();
                Axes::new(cos, sin) * radius
            };
            angle.into_iter().zip(radius).map(point).collect()
        } else {
            return Err(table.without("x_mm, y_mm, or angle_deg, radius_mm").into());
        };
        let centre_mm = centre(&points);
        let deviation = |point: &Axes| (point - centre_mm).norm() - radius_mm;
        let direction = |point: &Axes| (point.y - centre_mm.y).atan2(point.x - centre_mm.x).to_degrees();
        let by_deviation = |a: &&Axes, b: &&Axes| deviation(a).total_cmp(&deviation(b));
        let (Some(most), Some(least)) =
            (points.iter().max_by(by_deviation), points.iter().min_by(by_deviation))
        else {
            return Err(table.without("x_mm, y_mm, or angle_deg, radius_mm").into());
        };
        let deviations_mm = [most, least].map(deviation);
        let off_mm = largest(deviations_mm);
        if !(0.0..=MOST_OFF * radius_mm).contains(&off_mm) {
            return Err(BallbarError::Far { name: name.into(), off_mm, radius_mm });
        }
        let gap_deg = largest_gap(points.iter().map(direction).collect());
        if gap_deg > MOST_GAP_DEG {
            return Err(BallbarError::Gap { name: name.into(), gap_deg });
        }
        let sum: f64 = points.iter().map(|point| deviation(point).powi(2)).sum();
        let points_mm = points.iter().map(|point| point - centre_mm).collect();
        #[expect(clippy::cast_precision_loss, reason = "a count of points")]
        let rms_mm = (sum / points.len() as f64).sqrt();
        let directions_deg = [most, least].map(direction);
        Ok(Self { radius_mm, points_mm, centre_mm, deviations_mm, directions_deg, rms_mm })
    }

    /// The contour-error term, mm: the largest deviation, rounded up to 0.1 µm.
    #[must_use]
    pub fn term_mm(&self) -> f64 {
        (largest(self.deviations_mm) * 10_000.0).ceil() / 10_000.0
    }

    /// The picture of the test: the deviations, magnified, around the circle.
    #[must_use]
    pub fn svg(&self, name: &str) -> String {
        picture::svg(self, name)
    }

    /// The circular deviation G, mm: the range of the deviations.
    #[must_use]
    pub fn circular_deviation_mm(&self) -> f64 {
        self.deviations_mm[0] - self.deviations_mm[1]
    }
}

/// The size of the larger deviation.
fn largest([most, least]: [f64; 2]) -> f64 {
    most.abs().max(least.abs())
}

/// The centre of the circle with the least squares of the radial distances.
fn centre(points: &[Axes]) -> Axes {
    #[expect(clippy::cast_precision_loss, reason = "a count of points")]
    let count = points.len() as f64;
    let mut centre = points.iter().sum::<Axes>() / count;
    let mut radius = points.iter().map(|point| (point - centre).norm()).sum::<f64>() / count;
    for _ in 0..STEPS {
        let (mut normal, mut slope) = (Matrix3::zeros(), Vector3::zeros());
        for point in points {
            let spoke = point - centre;
            let far = spoke.norm().max(f64::MIN_POSITIVE);
            let row = Vector3::new(-spoke.x / far, -spoke.y / far, -1.0);
            normal += row * row.transpose();
            slope += row * (far - radius);
        }
        let Some(step) = normal.lu().solve(&-slope) else { break };
        centre += Axes::new(step.x, step.y);
        radius += step.z;
    }
    centre
}

/// The largest angle between two neighbours, degrees.
fn largest_gap(mut directions: Vec<f64>) -> f64 {
    directions.sort_by(f64::total_cmp);
    let around = directions.first().map_or(0.0, |first| first + 360.0);
    let next = directions.iter().skip(1).copied().chain([around]);
    directions.iter().zip(next).map(|(angle, next)| next - angle).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    /// Points of a circle of 50 mm whose radius varies, set up beside the centre.
    fn circle(turn_deg: f64, radius: impl Fn(f64) -> f64) -> NumberTable {
        let mut text = String::from("x_mm,y_mm\n");
        for number in 0..720 {
            let angle = (turn_deg * f64::from(number) / 720.0).to_radians();
            let radius = radius(angle);
            writeln!(text, "{},{}", 0.3 + radius * angle.cos(), -0.2 + radius * angle.sin()).unwrap();
        }
        NumberTable::parse("ball.csv", &text).unwrap()
    }

    #[test]
    fn deviations_are_those_about_the_circle_of_least_squares() {
        // An oval of mismatched axes: +8 µm along X, −8 along Y, and 3 µm too large.
        let table = circle(360.0, |angle| 50.003 + 0.008 * (2.0 * angle).cos());
        let found = CircularTest::of("ball.csv", &table, 50.0).unwrap();
        assert!((found.centre_mm - Axes::new(0.3, -0.2)).norm() < 1e-9);
        assert!((found.deviations_mm[0] - 0.011).abs() < 1e-6, "{found:?}");
        assert!((found.deviations_mm[1] + 0.005).abs() < 1e-6, "{found:?}");
        assert!((found.circular_deviation_mm() - 0.016).abs() < 1e-6);
        assert!((found.term_mm() - 0.011).abs() < 1.1e-4, "{}", found.term_mm());
        assert!(found.directions_deg[0].rem_euclid(180.0) < 1e-6, "{found:?}");
    }

    #[test]
    fn points_by_angle_and_radius_give_the_same() {
        let mut text = String::from("angle_deg,radius_mm\n");
        for number in 0..360 {
            writeln!(text, "{number},{}", 49.99).unwrap();
        }
        let table = NumberTable::parse("ball.csv", &text).unwrap();
        let found = CircularTest::of("ball.csv", &table, 50.0).unwrap();
        assert!((found.term_mm() - 0.01).abs() < 1.1e-4 && found.rms_mm > 0.009, "{found:?}");
    }

    #[test]
    fn tests_that_are_no_circle_are_refused() {
        let half = CircularTest::of("b.csv", &circle(300.0, |_| 50.0), 50.0).unwrap_err().to_string();
        assert!(half.contains("no point over 60° of the circle"), "{half}");
        let far = CircularTest::of("b.csv", &circle(360.0, |_| 50.0), 100.0).unwrap_err().to_string();
        assert!(far.contains("50.000 mm off the circle of 100 mm"), "{far}");
        let table = NumberTable::parse("b.csv", &("a\n".to_string() + &"1\n".repeat(200))).unwrap();
        let columns = CircularTest::of("b.csv", &table, 50.0).unwrap_err().to_string();
        assert!(columns.contains("has no columns x_mm, y_mm"), "{columns}");
    }
}
