//! Projection and colors for Python: arrays of points and values in, arrays of pixels and inks out.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use physcore_canvas::{Fog, Ink, Rgb, look_up, opaque};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{depth, rows};

/// Pixels (N, 2), depths behind the center (N,) and pixels per meter (N,).
type Projected<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>);

/// Projection of points to pixels.
#[pyclass(name = "Projection", module = "physcore._core", frozen)]
pub struct PyProjection(Dimension);

enum Dimension {
    Flat(physcore_canvas::Projection<2>),
    Deep(physcore_canvas::Projection<3>),
}

#[pymethods]
impl PyProjection {
    /// Create a projection. `axes` (D, D) point right, up and toward the eye; `center` (D,) has components along them.
    #[new]
    fn new(axes: Vec<Vec<f64>>, center: Vec<f64>, scale: f64, middle: [f64; 2], distance: f64) -> PyResult<Self> {
        match center.len() {
            2 => Ok(Self(Dimension::Flat(projection(&axes, &center, scale, middle, distance)?))),
            3 => Ok(Self(Dimension::Deep(projection(&axes, &center, scale, middle, distance)?))),
            other => Err(PyValueError::new_err(format!("center: must have 2 or 3 components, got {other}"))),
        }
    }

    /// Project points (N, D): pixels (N, 2), depths behind the center (N,) and pixels per meter (N,).
    fn project<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Projected<'py>> {
        match &self.0 {
            Dimension::Flat(projection) => projected(py, projection, &points),
            Dimension::Deep(projection) => projected(py, projection, &points),
        }
    }
}

fn projection<const D: usize>(
    axes: &[Vec<f64>],
    center: &[f64],
    scale: f64,
    middle: [f64; 2],
    distance: f64,
) -> PyResult<physcore_canvas::Projection<D>> {
    let refused = |_| PyValueError::new_err(format!("axes, center: must have the shapes ({D}, {D}) and ({D},)"));
    let rows: Vec<[f64; D]> = axes.iter().map(|axis| axis.as_slice().try_into()).collect::<Result<_, _>>().map_err(refused)?;
    let axes = rows.as_slice().try_into().map_err(refused)?;
    let center = center.try_into().map_err(refused)?;
    Ok(physcore_canvas::Projection { axes, center, scale, middle, distance })
}

fn projected<'py, const D: usize>(
    py: Python<'py>,
    projection: &physcore_canvas::Projection<D>,
    points: &PyReadonlyArray2<'py, f64>,
) -> PyResult<Projected<'py>> {
    let count = points.shape()[0];
    let points = rows::<f64, D>(points, count, "points")?;
    let (mut pixels, mut depths, mut scales) = (vec![[0.0; 2]; count], vec![0.0; count], vec![0.0; count]);
    py.detach(|| {
        for (((&point, pixel), depth), scale) in points.iter().zip(&mut pixels).zip(&mut depths).zip(&mut scales) {
            (*pixel, *depth, *scale) = projection.project(point);
        }
    });
    let pixels = PyArray1::from_vec(py, pixels.into_flattened()).reshape([count, 2])?;
    Ok((pixels, PyArray1::from_vec(py, depths), PyArray1::from_vec(py, scales)))
}

/// Lengths (N,) of vectors (N, D).
#[pyfunction]
pub fn norms<'py>(py: Python<'py>, vectors: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let values = vectors.as_slice().map_err(|_| PyValueError::new_err("vectors: must be C-contiguous"))?;
    let (length, dimension) = (|vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt(), vectors.shape()[1].max(1));
    let lengths = py.detach(|| values.chunks_exact(dimension).map(length).collect());
    Ok(PyArray1::from_vec(py, lengths))
}

/// Opaque inks (N, 4) of values (N,): the fraction from `low` to `high` indexes a color table (K, 3). Distant points fade into
/// the background. `fog` is half the depth range of the scene and the fade of the farthest point.
#[pyfunction]
#[pyo3(signature = (values, ends, table, background, depths=None, fog=None))]
pub fn tint<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    ends: [f64; 2],
    table: PyReadonlyArray2<'py, f64>,
    background: Rgb,
    depths: Option<PyReadonlyArray1<'py, f32>>,
    fog: Option<(f32, f32)>,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let (count, entries) = (values.len(), table.shape()[0]);
    let values = values.as_slice().map_err(|_| PyValueError::new_err("values: must be C-contiguous"))?;
    let table: Vec<[f32; 3]> =
        rows::<f64, 3>(&table, entries, "table")?.iter().map(|color| color.map(|value| value as f32)).collect();
    let depths = depth(depths.as_ref(), count)?;
    if table.is_empty() {
        return Err(PyValueError::new_err("table: must have at least one color"));
    }
    let ([low, high], (reach, strength)) = (ends, fog.unwrap_or((1.0, 0.0)));
    let fog = Fog { reach, strength, background };
    let mut inks = vec![[0; 4]; count];
    let (plain, per_value): (Vec<Ink>, f64) = (table.iter().copied().map(opaque).collect(), 1.0 / (high - low));
    py.detach(|| match depths {
        Some(depths) => {
            for ((value, &depth), ink) in values.iter().zip(depths).zip(&mut inks) {
                *ink = opaque(fog.seen(*look_up(&table, (value - low) * per_value), depth));
            }
        }
        None => {
            for (value, ink) in values.iter().zip(&mut inks) {
                *ink = *look_up(&plain, (value - low) * per_value);
            }
        }
    });
    PyArray1::from_vec(py, inks.into_flattened()).reshape([count, 4])
}
