//! Coloring of elements that share vertices, such as springs between particles.
//!
//! No two elements of a color share a vertex. Relaxations of one color are therefore independent: in any
//! order, at once, or on any thread, they have the same bits.

/// Elements color by color. Each has the first color that is free at all of its vertices, which are some of `0..count` and
/// different from each other. Within a color, elements are sorted by their vertices, so that their memory is near.
pub fn colored<E: Copy, const N: usize>(elements: &[E], vertices_of: impl Fn(&E) -> [u32; N], count: usize) -> Vec<Vec<E>> {
    // Colors in use at each vertex, one bit each.
    let mut taken: Vec<Vec<u64>> = vec![Vec::new(); count];
    let mut colors: Vec<Vec<E>> = Vec::new();
    for &element in elements {
        let vertices = vertices_of(&element).map(|vertex| vertex as usize);
        let word = |at: usize| vertices.iter().filter_map(|&vertex| taken[vertex].get(at)).fold(0, |word, bits| word | bits);
        let mut at = 0;
        while word(at) == u64::MAX {
            at += 1;
        }
        let color = 64 * at + word(at).trailing_ones() as usize;
        for vertex in vertices {
            let words = taken[vertex].len().max(at + 1);
            taken[vertex].resize(words, 0);
            taken[vertex][at] |= 1 << (color % 64);
        }
        colors.resize(colors.len().max(color + 1), Vec::new());
        colors[color].push(element);
    }
    colors.iter_mut().for_each(|color| color.sort_by_key(&vertices_of));
    colors
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn elements_of_a_color_share_no_vertex(
            elements in prop::collection::vec(prop::sample::subsequence((0..12_u32).collect::<Vec<_>>(), 3), 0..80),
        ) {
            let elements: Vec<[u32; 3]> = elements.iter().map(|vertices| [vertices[2], vertices[0], vertices[1]]).collect();
            let colors = colored(&elements, |&vertices| vertices, 12);
            for color in &colors {
                let mut vertices = color.concat();
                vertices.sort_unstable();
                prop_assert!(vertices.windows(2).all(|pair| pair[0] != pair[1]), "{color:?}");
                prop_assert!(color.is_sorted(), "{color:?}");
            }
            let (mut found, mut expected) = (colors.concat(), elements);
            found.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_chain_has_two_colors_and_a_star_one_for_each_ray() {
        let chain: Vec<[u32; 2]> = (0..9).map(|link| [link, link + 1]).collect();
        assert_eq!(colored(&chain, |&ends| ends, 10).len(), 2);
        // More colors than the bits of one word.
        let star: Vec<[u32; 2]> = (1..=200).map(|ray| [0, ray]).collect();
        let colors = colored(&star, |&ends| ends, 201);
        assert_eq!(colors.concat(), star);
        assert_eq!(colors.len(), 200);
    }
}
