//! Canvas for Python: arrays of shapes in, pixels out. The interpreter is free meanwhile.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use std::sync::Arc;

use numpy::{
    PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods,
};
use physcore_canvas::{
    Align, CanvasError, Disc, Drop, Exposure, Eye, Ground, Halo, Ink, Lens, Light, Line, Painting, Rgb, Samples, Shading, Sky,
    Trails, Triangle,
};
use physcore_engine::parallel::attend;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{column, depth, plane, rows};
use crate::errors::{FileError, exception};
use crate::world::interrupted;

/// Picture of sRGB pixels to draw on.
#[pyclass(name = "Canvas", module = "physcore._core")]
pub struct PyCanvas {
    pub(crate) picture: physcore_canvas::Canvas,
    painting: Painting,
}

#[pymethods]
impl PyCanvas {
    /// Create a picture of `width` × `height` pixels, drawn with `samples` × `samples` samples per pixel.
    #[new]
    #[pyo3(signature = (width, height, background, samples = 1))]
    fn new(width: usize, height: usize, background: Rgb, samples: usize) -> PyResult<Self> {
        let picture = physcore_canvas::Canvas::supersampled(width, height, background, samples).map_err(python_error)?;
        Ok(Self { picture, painting: Painting::default() })
    }

    /// Restore the backdrop.
    fn clear(&mut self) {
        self.picture.clear();
    }

    /// Make the present picture the backdrop.
    fn keep(&mut self) {
        self.picture.keep();
    }

    /// Restrict all later drawing to these columns and rows.
    fn clip(&mut self, left: usize, top: usize, right: usize, bottom: usize) {
        self.picture.clip(left, top, right, bottom);
    }

    /// Add discs to the painting. Without depths they are painted at once, over everything added before.
    #[pyo3(signature = (centers, radii, colors, depths=None, shading=0.0))]
    fn discs(
        &mut self,
        py: Python<'_>,
        centers: PyReadonlyArray2<'_, f32>,
        radii: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray1<'_, f32>>,
        shading: f32,
    ) -> PyResult<()> {
        let count = centers.shape()[0];
        let centers = rows::<f32, 2>(&centers, count, "centers")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let (radii, depths) = (column(&radii, count, "radii")?, depth(depths.as_ref(), count)?);
        let disc =
            move |((&center, &radius), &color): ((&[f32; 2], &f32), &Ink)| Disc { center, radius, color, shading, softness: 1.0 };
        let discs = centers.iter().zip(radii).zip(colors).map(disc);
        let Self { picture, painting } = self;
        match depths {
            Some(depths) => discs.zip(depths).for_each(|(disc, &depth)| painting.disc(disc, depth)),
            None if count < MANY => py.detach(|| painting.paint_discs(picture, &discs)),
            None => {
                let (centers, radii, colors) = (centers.to_vec(), radii.to_vec(), colors.to_vec());
                self.paint_at_length(py, move |painting, picture| {
                    painting.paint_discs(picture, &centers.iter().zip(&radii).zip(&colors).map(disc));
                })?;
            }
        }
        Ok(())
    }

    /// Add lines to the painting, with the depths of their ends (N, 2).
    #[pyo3(signature = (ends, widths, colors, depths=None))]
    fn lines(
        &mut self,
        ends: PyReadonlyArray2<'_, f32>,
        widths: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<()> {
        let count = ends.shape()[0];
        let ends = rows::<f32, 4>(&ends, count, "ends")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let widths = column(&widths, count, "widths")?;
        let depths = depths.as_ref().map(|depths| rows::<f32, 2>(depths, count, "depths")).transpose()?;
        for (index, ((&[x0, y0, x1, y1], &width), &color)) in ends.iter().zip(widths).zip(colors).enumerate() {
            let line = Line { from: [x0, y0], to: [x1, y1], width, color, softness: 1.0 };
            self.painting.line(line, depths.map_or([0.0; 2], |depths| depths[index]));
        }
        Ok(())
    }

    /// Add triangles with corners (T, 3, 2) and corner colors (T, 3, 4). Depths are those of the corners (T, 3), or of the whole
    /// triangle (T, 1), which then receives no light. A texture requires texture coordinates of the corners; a weave is
    /// their coordinates (T, 3, 2) across its two sets of threads [threads].
    #[pyo3(signature = (corners, colors, depths=None, texture=None, places=None, weave=None))]
    fn triangles(
        &mut self,
        corners: PyReadonlyArray2<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray2<'_, f32>>,
        texture: Option<PyRef<'_, PyTexture>>,
        places: Option<PyReadonlyArray2<'_, f32>>,
        weave: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<()> {
        let count = corners.shape()[0];
        let corners = rows::<f32, 6>(&corners, count, "corners")?;
        let colors = rows::<u8, 12>(&colors, count, "colors")?;
        let places = places.as_ref().map(|places| rows::<f32, 6>(places, count, "places")).transpose()?;
        let weave = weave.as_ref().map(|weave| rows::<f32, 6>(weave, count, "weave")).transpose()?;
        let lit = depths.as_ref().is_some_and(|depths| depths.shape()[1] != 1);
        let depths: Option<Vec<[f32; 3]>> = match &depths {
            None => None,
            Some(depths) if lit => Some(rows::<f32, 3>(depths, count, "depths")?.to_vec()),
            Some(depths) => Some(rows::<f32, 1>(depths, count, "depths")?.iter().map(|&[depth]| [depth; 3]).collect()),
        };
        let texture = texture.map(|texture| self.painting.texture(Arc::clone(&texture.texture)));
        for (index, (corners, colors)) in corners.iter().zip(colors).enumerate() {
            let texture_coordinates = places.map_or([[0.0; 2]; 3], |places| thirds(&places[index]));
            let depths = depths.as_ref().map_or([0.0; 3], |depths| depths[index]);
            let triangle = Triangle { corners: thirds(corners), colors: thirds(colors), depths, lit, texture_coordinates };
            let depth = (depths[0] + depths[1] + depths[2]) / 3.0;
            match weave {
                Some(weave) => self.painting.woven(triangle, texture, thirds(&weave[index]), depth),
                None => self.painting.triangle(triangle, texture, depth),
            }
        }
        Ok(())
    }

    /// Add halos of light, or of colored shadow.
    #[pyo3(signature = (centers, radii, colors, depths=None, shadow=false))]
    fn halos(
        &mut self,
        centers: PyReadonlyArray2<'_, f32>,
        radii: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray1<'_, f32>>,
        shadow: bool,
    ) -> PyResult<()> {
        let count = centers.shape()[0];
        let centers = rows::<f32, 2>(&centers, count, "centers")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let (radii, depths) = (column(&radii, count, "radii")?, depth(depths.as_ref(), count)?);
        for (index, ((&center, &radius), &color)) in centers.iter().zip(radii).zip(colors).enumerate() {
            self.painting.halo(Halo { center, radius, color, shadow }, depths.map_or(0.0, |depths| depths[index]));
        }
        Ok(())
    }

    /// Add particles of a liquid surface. `scale` is the number of pixels per meter of depth, `glow` the share of its color that
    /// the liquid emits.
    #[pyo3(signature = (centers, radii, colors, sky, depths=None, scale=0.0, glow=0.0))]
    #[expect(clippy::too_many_arguments, reason = "one call for each frame")]
    fn liquid(
        &mut self,
        centers: PyReadonlyArray2<'_, f32>,
        radii: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        sky: PyRef<'_, PySky>,
        depths: Option<PyReadonlyArray1<'_, f32>>,
        scale: f32,
        glow: f32,
    ) -> PyResult<()> {
        let count = centers.shape()[0];
        let centers = rows::<f32, 2>(&centers, count, "centers")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let (radii, depths) = (column(&radii, count, "radii")?, depth(depths.as_ref(), count)?);
        self.painting.begin_liquid(if depths.is_some() { scale } else { 0.0 }, sky.sky, glow);
        for (index, ((&center, &radius), &color)) in centers.iter().zip(radii).zip(colors).enumerate() {
            self.painting.drop(Drop { center, radius, color, depth: depths.map_or(0.0, |depths| depths[index]) });
        }
        Ok(())
    }

    /// Add trails: the last positions (K, N, 2) of N points, the oldest first, as lines that taper with age. With `fade`, a
    /// background and the fraction of color left at the fresh end, the trails fade into this background.
    #[pyo3(signature = (past, widths, colors, fade=None, gaps=None, depths=None))]
    fn trails(
        &mut self,
        past: PyReadonlyArray3<'_, f32>,
        widths: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        fade: Option<(Rgb, f32)>,
        gaps: Option<PyReadonlyArray2<'_, bool>>,
        depths: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<()> {
        let [moments, count] = [past.shape()[0], past.shape()[1]];
        let (past, rest) = past.as_slice().map_err(|_| PyValueError::new_err("past: must be C-contiguous"))?.as_chunks::<2>();
        let (widths, colors) = (column(&widths, count, "widths")?, rows::<u8, 4>(&colors, count, "colors")?);
        let gaps = gaps.as_ref().map(|gaps| plane(gaps, [moments.saturating_sub(1), count], "gaps")).transpose()?;
        let depths = depths.as_ref().map(|depths| plane(depths, [moments, count], "depths")).transpose()?;
        if !rest.is_empty() || past.len() != moments * count {
            return Err(PyValueError::new_err("past: must have the shape (K, N, 2)"));
        }
        let trails = Trails { past, widths, colors, fade, gaps, depths };
        let mixing = trails.mixing();
        trails.lines().for_each(|(line, depth)| self.painting.trail(line, mixing, depth));
        Ok(())
    }

    /// Apply a thin lens to everything added later: pixels of blur per meter from the focus, and the distance of the eye [m].
    fn lens(&mut self, blur: f32, distance: f32) {
        self.painting.look_through(Lens { blur, distance });
    }

    /// Record the depth of everything drawn later. The eye is at this distance from its focus, which lies at the pixel `middle`
    /// and has `scale` pixels per meter.
    fn eye(&mut self, scale: f32, middle: [f32; 2], distance: f32) {
        self.picture.look_from(Eye { scale, middle, distance });
    }

    /// Light everything painted later.
    ///
    /// - `lamp`: direction to the lamp, right, up and toward the eye.
    /// - `shadow`, `occlusion`: shares of light that shadows and ambient occlusion take.
    /// - `reach`: radius of ambient occlusion around a pixel [pixels].
    fn light(&mut self, lamp: [f32; 3], shadow: f32, occlusion: f32, reach: f32) {
        self.painting.light(Light { lamp, shadow, occlusion, reach });
    }

    /// Draw ground at once.
    ///
    /// - `normal`: unit normal.
    /// - `center`, `size`: brightest point, and the distance from it at which half of the color is left.
    /// - `color`: color at the brightest point.
    /// - `along`, `grid`: direction of the lines of a grid, which run along and across it; their color, distance and opacity.
    /// - `part`: for a wall, the pixels of its corners and its opacity.
    #[pyo3(signature = (normal, center, size, color, along, grid=None, part=None))]
    #[expect(clippy::too_many_arguments, reason = "one call for each film")]
    fn ground(
        &mut self,
        py: Python<'_>,
        normal: [f32; 3],
        center: [f32; 3],
        size: f32,
        color: Rgb,
        along: [f32; 3],
        grid: Option<(Rgb, f32, f32)>,
        part: Option<([[f32; 2]; 4], f32)>,
    ) {
        let picture = &mut self.picture;
        py.detach(|| picture.ground(&Ground { normal, center, size, color, grid, along, part }));
    }

    /// Lighten the background toward a pixel, at once, by a share of the way to a color.
    fn backdrop(&mut self, py: Python<'_>, center: [f32; 2], radius: f32, color: Rgb, share: f32) {
        let picture = &mut self.picture;
        py.detach(|| picture.backdrop(center, radius, color, share));
    }

    /// Paint all added shapes, from far to near.
    fn paint(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.painting.len() >= MANY {
            return self.paint_at_length(py, physcore_canvas::Painting::paint);
        }
        let Self { picture, painting } = self;
        py.detach(|| painting.paint(picture));
        Ok(())
    }

    /// Fill a convex polygon at once.
    fn polygon(&mut self, corners: PyReadonlyArray2<'_, f32>, color: Ink) -> PyResult<()> {
        let corners = rows::<f32, 2>(&corners, corners.shape()[0], "corners")?;
        self.picture.polygon(corners, color);
        Ok(())
    }

    /// Copy a picture (H, W, 3) at once, with its upper left corner at a pixel.
    fn picture(&mut self, py: Python<'_>, pixels: PyReadonlyArray3<'_, u8>, left: i32, top: i32) -> PyResult<()> {
        let (width, colors) = (pixels.shape()[1], texels(&pixels)?);
        let picture = &mut self.picture;
        py.detach(|| picture.picture(colors, width, [left, top]));
        Ok(())
    }

    /// Draw the density of points (N, 2) at once, as light that spreads over `spread` pixels, in the colors of a table (K, 3).
    fn density(
        &mut self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f32>,
        table: PyReadonlyArray2<'_, u8>,
        strength: f32,
        spread: f32,
    ) -> PyResult<()> {
        let points = rows::<f32, 2>(&points, points.shape()[0], "points")?;
        let table = rows::<u8, 3>(&table, table.shape()[0], "table")?;
        let picture = &mut self.picture;
        py.detach(|| picture.density(points, &Exposure { table, strength, spread }));
        Ok(())
    }

    /// Add the light of points (N, 2) of these colors (N, 3) at once, which spreads over `spread` pixels; a shadow of them on a
    /// light background.
    fn starlight(
        &mut self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        strength: f32,
        spread: f32,
        shadow: bool,
    ) -> PyResult<()> {
        let count = points.shape()[0];
        let (points, colors) = (rows::<f32, 2>(&points, count, "points")?, rows::<u8, 3>(&colors, count, "colors")?);
        let picture = &mut self.picture;
        py.detach(|| picture.starlight(points, colors, strength, spread, shadow));
        Ok(())
    }

    /// Write one line of text at once; `align` is -1, 0 or 1 for left, center and right.
    fn text(&mut self, text: &str, x: i32, y: i32, height: usize, color: Ink, align: i32) {
        let align = match align {
            ..0 => Align::Left,
            0 => Align::Center,
            1.. => Align::Right,
        };
        self.picture.text(text, [x, y], height, color, align);
    }

    /// Return a copy of the pixels, (height, width, 3).
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let picture = self.picture.reduced();
        let bytes: Vec<u8> = picture.pixels().iter().flat_map(|&[red, green, blue, _]| [red, green, blue]).collect();
        PyArray1::from_vec(py, bytes).reshape([picture.height(), picture.width(), 3])
    }
}

/// Number of shapes whose painting may take as long as an interrupt may wait.
const MANY: usize = 20_000;

impl PyCanvas {
    /// Paints while signals are handled. After an interrupt the painting is empty; a detached thread finishes the picture and
    /// drops it.
    fn paint_at_length(
        &mut self,
        py: Python<'_>,
        paint: impl FnOnce(&mut Painting, &mut physcore_canvas::Canvas) + Send + 'static,
    ) -> PyResult<()> {
        let Self { mut picture, mut painting } = std::mem::replace(self, Self::new(1, 1, [0; 3], 1)?);
        let job = move || {
            paint(&mut painting, &mut picture);
            Self { picture, painting }
        };
        *self = py.detach(|| attend(1, &interrupted, move |_| job())).map_err(|error| exception(py, error))?;
        Ok(())
    }
}

/// Sky that water reflects.
#[pyclass(name = "Sky", module = "physcore._core", frozen)]
pub struct PySky {
    sky: Sky,
}

#[pymethods]
impl PySky {
    /// Create a sky.
    ///
    /// - `horizon`, `zenith`: colors.
    /// - `up`: unit vector to the zenith, right, up and toward the eye.
    /// - `brightness`: relative to white in the picture.
    #[new]
    fn new(horizon: Rgb, zenith: Rgb, up: [f32; 3], brightness: f32) -> Self {
        Self { sky: Sky { horizon, zenith, up, brightness } }
    }

    #[getter]
    fn horizon(&self) -> Rgb {
        self.sky.horizon
    }

    #[getter]
    fn zenith(&self) -> Rgb {
        self.sky.zenith
    }

    #[getter]
    fn up(&self) -> [f32; 3] {
        self.sky.up
    }

    #[getter]
    fn brightness(&self) -> f32 {
        self.sky.brightness
    }

    /// Colors (N, 3) of a surface with the reflected sky. Its own colors, unit normals and points are given along the axes of the
    /// camera. The eye is at this distance from the origin.
    fn reflected<'py>(
        &self,
        py: Python<'py>,
        colors: PyReadonlyArray2<'py, f64>,
        normals: PyReadonlyArray2<'py, f64>,
        places: PyReadonlyArray2<'py, f64>,
        distance: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let count = colors.shape()[0];
        let (colors, normals) = (rows::<f64, 3>(&colors, count, "colors")?, rows::<f64, 3>(&normals, count, "normals")?);
        let places = rows::<f64, 3>(&places, count, "places")?;
        let single = |vector: &[f64; 3]| vector.map(|component| component as f32);
        let mut lit = vec![[0.0; 3]; count];
        py.detach(|| {
            for (((lit, color), normal), &[x, y, z]) in lit.iter_mut().zip(colors).zip(normals).zip(places) {
                let way = if distance.is_finite() { [-x, -y, distance - z] } else { [0.0, 0.0, 1.0] };
                let length = way.iter().map(|component| component * component).sum::<f64>().sqrt();
                let toward = way.map(|component| (component / length) as f32);
                *lit = self.sky.reflected(single(color), single(normal), toward, 1.0).map(f64::from);
            }
        });
        PyArray1::from_vec(py, lit.into_flattened()).reshape([count, 3])
    }
}

/// Texture image for surfaces.
#[pyclass(name = "Texture", module = "physcore._core", frozen)]
pub struct PyTexture {
    texture: Arc<physcore_canvas::Texture>,
}

#[pymethods]
impl PyTexture {
    /// Create a texture from pixels (height, width, 3).
    #[new]
    fn new(pixels: PyReadonlyArray3<'_, u8>) -> PyResult<Self> {
        let texture = physcore_canvas::Texture::new(pixels.shape()[1], texels(&pixels)?.to_vec()).map_err(python_error)?;
        Ok(Self { texture: Arc::new(texture) })
    }
}

/// Returns the pixels of a picture (H, W, 3).
fn texels<'a>(pixels: &'a PyReadonlyArray3<'_, u8>) -> PyResult<&'a [Rgb]> {
    if pixels.shape()[2] != 3 {
        return Err(PyValueError::new_err(format!("pixels: must have the shape (H, W, 3), got {:?}", pixels.shape())));
    }
    Ok(pixels.as_slice().map_err(|_| PyValueError::new_err("pixels: must be C-contiguous"))?.as_chunks().0)
}

/// Width of a line of text that is `height` pixels high [pixels].
#[pyfunction]
pub fn text_width(text: &str, height: usize) -> usize {
    physcore_canvas::text_width(text, height)
}

/// Characters of a text that no font has, each once.
#[pyfunction]
pub fn missing_signs(text: &str) -> PyResult<String> {
    physcore_canvas::missing_signs(text).map_err(python_error)
}

/// Coverage of each pixel (H, W) by cells (nx, ny) that are 1, not 0. The other arguments are those of `heatmap`.
#[pyfunction]
pub fn coverage<'py>(
    py: Python<'py>,
    mask: PyReadonlyArray2<'py, f64>,
    size: [usize; 2],
    corner: [f64; 2],
    step: f64,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let cells = [mask.shape()[0], mask.shape()[1]];
    let samples = Samples { values: plane(&mask, cells, "mask")?, cells, size, corner, step };
    if samples.values.is_empty() || !(step > 0.0 && step.is_finite()) {
        return Err(PyValueError::new_err("mask, step: must not be empty, and the step above 0"));
    }
    let covered = py.detach(|| physcore_canvas::coverage(samples));
    PyArray1::from_vec(py, covered).reshape([size[1], size[0]])
}

/// Picture (H, W, 3) of values at the cell centers of a grid (nx, ny). `walls` is the coverage of pixels by walls (H, W), with an
/// ink.
///
/// - `size`: (W, H).
/// - `corner`: center of the upper left pixel relative to that of the lower left cell, in cells.
/// - `step`: number of cells per pixel.
/// - `table`: colors (K, 3) of values between the `ends`.
/// - `isolines`: distance and ink of isolines.
/// - `relief`: strength of light from the upper left.
#[pyfunction]
#[pyo3(signature = (values, size, corner, step, table, ends, walls=None, isolines=None, relief=0.0))]
#[expect(clippy::too_many_arguments, reason = "one call for each frame")]
pub fn heatmap<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    size: [usize; 2],
    corner: [f64; 2],
    step: f64,
    table: PyReadonlyArray2<'py, u8>,
    ends: [f64; 2],
    walls: Option<(PyReadonlyArray2<'py, u8>, Rgb)>,
    isolines: Option<(f64, Ink)>,
    relief: f32,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let [columns, lines] = [values.shape()[0], values.shape()[1]];
    let table = rows::<u8, 3>(&table, table.shape()[0], "table")?;
    let numbers = plane(&values, [columns, lines], "values")?;
    let walls = match &walls {
        Some((mask, ink)) => Some((plane(mask, [size[1], size[0]], "walls")?, *ink)),
        None => None,
    };
    if table.is_empty() || numbers.is_empty() || !(step > 0.0 && step.is_finite()) {
        return Err(PyValueError::new_err("values, table, step: must not be empty, and the step above 0"));
    }
    let samples = Samples { values: numbers, cells: [columns, lines], size, corner, step };
    let shading = Shading { table, ends, isolines, relief };
    let pixels = py.detach(|| physcore_canvas::heatmap(samples, &shading, walls));
    PyArray1::from_vec(py, pixels.into_flattened()).reshape([size[1], size[0], 3])
}

/// Splits a row into three equal parts.
fn thirds<T: Copy, const N: usize, const W: usize>(row: &[T; W]) -> [[T; N]; 3] {
    std::array::from_fn(|corner| std::array::from_fn(|index| row[corner * N + index]))
}

pub(crate) fn python_error(error: CanvasError) -> PyErr {
    match error {
        CanvasError::Write(cause) => cause.into(),
        CanvasError::Font(_) => FileError::new_err(format!("{error}; install physcore anew")),
        other => PyValueError::new_err(other.to_string()),
    }
}
