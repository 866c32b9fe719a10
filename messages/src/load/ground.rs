//! Rules for uneven ground.

use super::check::{Checked, Validator};
use crate::scene::Ground;

/// Largest number of tiles. A scene with more would not fit into the environment variable in which it is handed to other processes.
const MAX_TILES: usize = 500;

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
        ground.random.size.iter().try_for_each(|&side| self.positive("plant.ground.random.size", side))?;
        self.not_negative("plant.ground.random.height", ground.random.height)
    }
}
