//! Rules for uneven ground.

use super::check::{Checked, Validator};
use crate::scene::Ground;

/// Largest number of tiles. A scene with more would not fit into the environment variable in which it is handed to other processes.
const MAX_TILES: usize = 500;
/// Shortest side of a random tile [m]. Tiles are counted by whole numbers of 64 bits: out to 9e9 m with such sides.
const MIN_SIDE: f64 = 1e-9;

impl Validator<'_> {
    /// Checks the tiles, which must not overlap, and the grid of random ones.
    pub(super) fn ground(&self, ground: &Ground) -> Checked {
        let (count, rule) = (ground.tiles.len(), format!("a scene holds at most {MAX_TILES} tiles"));
        self.require(count <= MAX_TILES, "number of plant.ground.tiles", count, rule)?;
        for (i, tile) in ground.tiles.iter().enumerate() {
            for (axis, range) in [("x", tile.x), ("y", tile.y)] {
                let rule = "the first value must be less than the last";
                let key = format!("plant.ground.tiles.{i}.{axis}");
                self.require(range[0] < range[1], &key, format!("{range:?}"), rule)?;
            }
            let other = ground.tiles[..i].iter().position(|other| tile.overlaps(other));
            let rule = format!("it must not overlap plant.ground.tiles.{}", other.unwrap_or(0));
            let ranges = format!("x {:?}, y {:?}", tile.x, tile.y);
            self.require(other.is_none(), &format!("plant.ground.tiles.{i}"), ranges, rule)?;
        }
        for side in ground.random.size {
            self.require(
                side >= MIN_SIDE,
                "plant.ground.random.size",
                format!("{side:?}"),
                "it must be at least 1e-9 m",
            )?;
        }
        self.not_negative("plant.ground.random.height", ground.random.height)
    }
}
