//! Tests of uniform grids.

use glam::DVec3;

use super::*;

/// Builds a grid from an item with these cells and periodic axes.
fn grid(cells: [f64; 3], periodic: [f64; 3]) -> Result<Grid> {
    let vector = |entries: [f64; 3]| Value::Vector(DVec3::from_array(entries));
    let record = Item::new(
        "Grid",
        [
            ("cells", vector(cells)),
            ("spacing", Value::Number(0.5)),
            ("origin", vector([1.0, 2.0, 3.0])),
            ("periodic", vector(periodic)),
        ],
    );
    Grid::declared(&Item::new("Wave", [("grid", Value::Record(Box::new(record)))]))
}

#[test]
fn axes_that_are_missing_come_first() {
    let plane = grid([4.0, 3.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
    assert_eq!((plane.cells, plane.periodic, plane.origin), ([1, 4, 3], [false, false, true], [0.0, 1.0, 2.0]));
    assert_eq!((plane.shape(), plane.rows(), plane.content()), (vec![4, 3], 4, 0.25));
    assert_eq!((plane.name(0), plane.name(7)), ("cell (0, 0)".to_owned(), "cell (2, 1)".to_owned()));
    assert_eq!(grid([4.0, 3.0, 2.0], [0.0; 3]).unwrap().name(9), "cell (1, 1, 1)");
    assert_eq!(grid([4.0, 0.0, 0.0], [0.0; 3]).unwrap().name(3), "cell (3)");
    for cells in [[0.0, 3.0, 0.0], [2.5, 0.0, 0.0], [0.0; 3], [1e6, 1e6, 0.0], [-1.0, 0.0, 0.0]] {
        assert!(grid(cells, [0.0; 3]).is_err(), "{cells:?}");
    }
}

#[test]
fn rows_have_neighbors_along_the_first_axes() {
    let solid = grid([2.0, 3.0, 5.0], [1.0, 0.0, 0.0]).unwrap();
    assert_eq!(solid.place(4), [1, 1]);
    assert_eq!([false, true].map(|upward| solid.beside(4, 0, upward)), [Some(1), Some(1)]);
    assert_eq!([false, true].map(|upward| solid.beside(4, 1, upward)), [Some(3), Some(5)]);
    assert_eq!([false, true].map(|upward| solid.beside(0, 1, upward)), [None, Some(1)]);
    assert_eq!([false, true].map(|upward| solid.beside(5, 1, upward)), [Some(4), None]);
}

/// Linear functions are interpolated exactly: Σ w f over the nearest centers is f at the point.
#[test]
fn weights_of_the_nearest_centers_interpolate() {
    let plane = grid([4.0, 3.0, 0.0], [0.0; 3]).unwrap();
    let center = |index: usize| [1.0 + 0.5 * ((index / 3) as f64 + 0.5), 2.0 + 0.5 * ((index % 3) as f64 + 0.5)];
    let function = |[x, y]: [f64; 2]| (1.0 + x) * (3.0 - y);
    for point in [[1.3, 2.9], [2.7, 2.25], [1.25, 3.25], [2.1, 2.6]] {
        let near = plane.nearest([0.0, point[0], point[1]]);
        let sum: f64 = near.iter().map(|&(index, weight)| weight * function(center(index))).sum();
        assert!((sum - function(point)).abs() < 1e-14, "{point:?}: {near:?}");
    }
    assert_eq!(plane.nearest([0.0, 1.1, 2.1]), [(0, 1.0)]);
    assert_eq!(plane.nearest([0.0, 9.0, 9.0]), [(11, 1.0)]);
    let ring = grid([4.0, 0.0, 0.0], [1.0; 3]).unwrap();
    assert_eq!(ring.nearest([0.0, 0.0, 1.0]), [(3, 0.5), (0, 0.5)]);
    assert_eq!(ring.nearest([0.0, 0.0, 3.125]), [(3, 0.25), (0, 0.75)]);
}

#[test]
fn equal_rows_share_their_memory() {
    let table = RowTable::new(100, 8, 0, |row, values| values[0] = usize::from(row % 3 == 0));
    assert_eq!(table.different().len(), 16);
    assert!((0..100).all(|row| table.row(row)[0] == usize::from(row % 3 == 0) && table.row(row)[1..] == [0; 7]));
}
