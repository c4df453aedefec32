//! Lattice types in files: the stored form of the kernel's types, and the checks of a reader.
//!
//! `#[serde(with = "crate::stored")]` serves one value, [`many`] a list, [`maybe`] an option.

use std::fmt::{self, Display, Formatter};
use std::marker::PhantomData;

use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Arc, Curve, Height, Length, Point, Segment, Turn, Vector};
use serde::de::{DeserializeOwned, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Type of the kernel with a stored form.
pub trait Stored: Sized {
    /// The stored form.
    type Form: Serialize + DeserializeOwned;

    /// The stored form of the value.
    fn store(&self) -> Self::Form;

    /// The value of a stored form.
    ///
    /// # Errors
    /// The reason why no value has this form.
    fn restore(form: Self::Form) -> Result<Self, impl Display>;
}

impl Stored for Point {
    type Form = [i32; 2];

    fn store(&self) -> Self::Form {
        [self.x.units(), self.y.units()]
    }

    fn restore([x, y]: Self::Form) -> Result<Self, impl Display> {
        Self::from_units(x.into(), y.into())
    }
}

impl Stored for Vector {
    type Form = [i32; 2];

    fn store(&self) -> Self::Form {
        [self.dx, self.dy]
    }

    fn restore([dx, dy]: Self::Form) -> Result<Self, impl Display> {
        Point::from_units(dx.into(), dy.into()).map(|point| point.minus(Point::ORIGIN))
    }
}

impl Stored for Length {
    type Form = i32;

    fn store(&self) -> Self::Form {
        self.units()
    }

    fn restore(units: Self::Form) -> Result<Self, impl Display> {
        Self::from_units(units.into())
    }
}

impl Stored for Height {
    type Form = i32;

    fn store(&self) -> Self::Form {
        self.units()
    }

    fn restore(units: Self::Form) -> Result<Self, impl Display> {
        Self::from_units(units.into())
    }
}

/// Height zero: where the tool of a machine with two axes stands. Files leave it out.
#[must_use]
pub fn height_zero() -> Height {
    Height::ZERO
}

/// Whether a file leaves the height out.
#[must_use]
pub fn is_height_zero(height: &Height) -> bool {
    *height == Height::ZERO
}

impl Stored for Window {
    type Form = [i32; 4];

    fn store(&self) -> Self::Form {
        let (x0, y0, x1, y1) = self.corners();
        [x0, y0, x1, y1]
    }

    fn restore([x0, y0, x1, y1]: Self::Form) -> Result<Self, impl Display> {
        Ok::<_, fmt::Error>(Self::from_corners(x0, y0, x1, y1))
    }
}

/// Stored form of a curve: its ends, and for an arc its centre and sense.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveForm {
    /// A line.
    Line([i32; 4]),
    /// A counter-clockwise arc.
    Counterclockwise([i32; 4], [i32; 2]),
    /// A clockwise arc.
    Clockwise([i32; 4], [i32; 2]),
}

impl Stored for Curve {
    type Form = CurveForm;

    fn store(&self) -> CurveForm {
        let ([a, b], [c, d]) = (self.from().store(), self.to().store());
        let ends = [a, b, c, d];
        match self {
            Self::Line(_) => CurveForm::Line(ends),
            Self::Arc(arc) if arc.turn() == Turn::CounterClockwise => {
                CurveForm::Counterclockwise(ends, arc.centre().store())
            }
            Self::Arc(arc) => CurveForm::Clockwise(ends, arc.centre().store()),
        }
    }

    fn restore(form: CurveForm) -> Result<Self, impl Display> {
        let at = |x: i32, y: i32| Point::from_units(x.into(), y.into()).map_err(|error| error.to_string());
        let arc = |[a, b, c, d]: [i32; 4], [x, y]: [i32; 2], turn| {
            Arc::new(at(a, b)?, at(c, d)?, at(x, y)?, turn).map(Self::Arc).map_err(|error| error.to_string())
        };
        match form {
            CurveForm::Line([a, b, c, d]) => Ok(Self::Line(Segment { from: at(a, b)?, to: at(c, d)? })),
            CurveForm::Counterclockwise(ends, centre) => arc(ends, centre, Turn::CounterClockwise),
            CurveForm::Clockwise(ends, centre) => arc(ends, centre, Turn::Clockwise),
        }
    }
}

impl Stored for Bezier {
    type Form = Vec<([i32; 2], u64)>;

    fn store(&self) -> Self::Form {
        self.control().iter().zip(self.weights()).map(|(point, &weight)| (point.store(), weight)).collect()
    }

    fn restore(form: Self::Form) -> Result<Self, impl Display> {
        let points = form.iter().map(|&(at, _)| Point::restore(at).map_err(|error| error.to_string()));
        let control = points.collect::<Result<_, _>>()?;
        let weights = form.into_iter().map(|(_, weight)| weight).collect();
        Self::new(control, weights).map_err(|error| error.to_string())
    }
}

/// Writes a value in its stored form.
///
/// # Errors
/// The error of the serializer.
pub fn serialize<T: Stored, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    value.store().serialize(serializer)
}

/// Reads a value from its stored form.
///
/// # Errors
/// The error of the deserializer; also one for a form that no value has.
pub fn deserialize<'de, T: Stored, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::restore(T::Form::deserialize(deserializer)?).map_err(D::Error::custom)
}

/// Lists of values.
pub mod many {
    use super::*;

    /// Largest number of elements to reserve memory for in advance.
    const RESERVED: usize = 4096;

    /// Writes a list.
    ///
    /// # Errors
    /// The error of the serializer.
    pub fn serialize<T: Stored, S: Serializer>(values: &[T], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().map(Stored::store))
    }

    /// Reads a list.
    ///
    /// # Errors
    /// As [`super::deserialize`].
    pub fn deserialize<'de, T: Stored, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
        struct List<T>(PhantomData<T>);
        impl<'de, T: Stored> Visitor<'de> for List<T> {
            type Value = Vec<T>;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
                let mut values = Vec::with_capacity(list.size_hint().unwrap_or(0).min(RESERVED));
                while let Some(form) = list.next_element()? {
                    values.push(T::restore(form).map_err(A::Error::custom)?);
                }
                Ok(values)
            }
        }
        deserializer.deserialize_seq(List(PhantomData))
    }
}

/// Values that may be missing.
pub mod maybe {
    use super::*;

    /// Writes an option.
    ///
    /// # Errors
    /// The error of the serializer.
    pub fn serialize<T: Stored, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        value.as_ref().map(Stored::store).serialize(serializer)
    }

    /// Reads an option.
    ///
    /// # Errors
    /// As [`super::deserialize`].
    pub fn deserialize<'de, T: Stored, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
        let form = Option::<T::Form>::deserialize(deserializer)?;
        form.map(T::restore).transpose().map_err(D::Error::custom)
    }
}
