//! Mass properties and overlaps of the shapes of rigid bodies, and points in them, for Python.

use glam::{DQuat, DVec3};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use physcore_engine::systems::matter::{RigidPose, overlaps};
use physcore_rigid::rotation::Orientation;
use physcore_rigid::shapes::SolidShape;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::exception;
use crate::record::Reader;
use crate::scene;

/// Area or volume, center of mass (3,) [m], and inertia tensor (3, 3) about it per unit density.
type ShapeProperties<'py> = (f64, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Whether each of the points (N, 3) is in a body. The bodies have the shape of a record, positions (B, 3) and orientations
/// (w, x, y, z), (B, 4).
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]
pub fn points_inside<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    dimension: usize,
    points: PyReadonlyArray2<'py, f64>,
    positions: PyReadonlyArray2<'py, f64>,
    orientations: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let mut reader = Reader { dimension, functions: Vec::new() };
    let kind: String = record.get_item("kind")?.extract()?;
    let (shape, _) = SolidShape::declared(&reader.item(record, kind)?, dimension).map_err(|error| exception(py, error))?;
    let [points, centers] = [points.as_array(), positions.as_array()]
        .map(|rows| rows.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect::<Vec<_>>());
    let turns = orientations.as_array();
    let turns = turns.rows().into_iter().map(|row| DQuat::from_xyzw(row[1], row[2], row[3], row[0]));
    let bodies: Vec<(DVec3, DQuat)> = centers.into_iter().zip(turns).collect();
    let is_inside = |point: DVec3| shape.contains_at(bodies.iter().copied(), point);
    Ok(PyArray1::from_iter(py, points.into_iter().map(is_inside)))
}

/// Mass properties of the shape that a record declares.
#[pyfunction]
pub fn shape_properties<'py>(py: Python<'py>, record: &Bound<'py, PyAny>, dimension: usize) -> PyResult<ShapeProperties<'py>> {
    let mut reader = Reader { dimension, functions: Vec::new() };
    let kind: String = record.get_item("kind")?.extract()?;
    let item = reader.item(record, kind)?;
    let (_, mass) = SolidShape::declared(&item, dimension).map_err(|error| exception(py, error))?;
    let rows: Vec<Vec<f64>> = mass.inertia.transpose().to_cols_array_2d().map(|row| row.to_vec()).to_vec();
    Ok((mass.size, PyArray1::from_slice(py, &mass.center.to_array()), PyArray2::from_vec2(py, &rows)?))
}

/// Depth of an overlap [m], size of the smaller body [m], and paths of both bodies.
type OverlapRow = (f64, f64, String, String);

/// Overlaps of the rigid bodies of a scene in several frames, from positions (F·B·D,) [m], and from angles (F·B,) or unit
/// quaternions (w, x, y, z), (F·B·4,).
#[pyfunction]
pub fn rigid_overlaps(
    py: Python<'_>,
    scene: &Bound<'_, PyDict>,
    bodies: usize,
    positions: &Bound<'_, PyAny>,
    turns: &Bound<'_, PyAny>,
) -> PyResult<Vec<Vec<OverlapRow>>> {
    let numbers = |array: &Bound<'_, PyAny>| -> PyResult<Vec<f64>> {
        let flat: PyReadonlyArray1<'_, f64> = array.extract()?;
        scene::copied(&flat)
    };
    let (positions, turns) = (numbers(positions)?, numbers(turns)?);
    let (scene, _) = scene::read(scene)?;
    let (dimension, components) = (scene.dimension, if scene.dimension == 2 { 1 } else { 4 });
    let center = |row: &[f64]| DVec3::new(row[0], row[1], row.get(2).copied().unwrap_or(0.0));
    let turn = |row: &[f64]| match *row {
        [w, x, y, z] => Orientation::spatial(DQuat::from_xyzw(x, y, z, w)),
        _ => Orientation::planar(row[0]),
    };
    let poses = positions.chunks_exact(dimension).map(center).zip(turns.chunks_exact(components).map(turn));
    let poses: Vec<RigidPose> = poses.collect();
    let frames: Vec<Vec<RigidPose>> = poses.chunks_exact(bodies).map(<[RigidPose]>::to_vec).collect();
    let found = py.detach(|| overlaps(&scene, &frames)).map_err(|error| exception(py, error))?;
    let rows = found.into_iter().map(|frame| {
        let row = |overlap: physcore_rigid::world::Overlap| {
            let [one, other] = overlap.names;
            (overlap.depth, overlap.size, one, other)
        };
        frame.into_iter().map(row).collect()
    });
    Ok(rows.collect())
}
