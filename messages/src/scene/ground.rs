//! Uneven ground: horizontal tiles at different heights.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Range of a tile along an axis for which the scene gives none [m]. No robot leaves it.
const EVERYWHERE: [f64; 2] = [-1e9, 1e9];
/// Size of random tiles along x and y in a scene that gives none [m].
const TILE_SIZE: [f64; 2] = [0.2, 0.2];

/// Greatest number of random tiles that are drawn in each direction.
const DRAWN: f64 = 30.0;

/// Heights of the ground. By default it is the plane z = 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Rectangles at heights of their own, for steps and kerbs. They must not overlap.
    pub tiles: Vec<GroundTile>,
    /// Tiles at random heights wherever `tiles` has none.
    pub random: RandomTiles,
}

/// A rectangle of the ground, with edges along the axes of W.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundTile {
    /// First and last x; absent: all x [m].
    #[serde(default = "everywhere")]
    pub x: [f64; 2],
    /// First and last y; absent: all y [m].
    #[serde(default = "everywhere")]
    pub y: [f64; 2],
    /// Height [m].
    pub height: f64,
}

/// A grid of tiles whose heights are random.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RandomTiles {
    /// Length of a tile along x and along y. One tile has a corner at the origin of W [m].
    pub size: [f64; 2],
    /// Greatest height; heights are spread evenly from its negative to it [m].
    pub height: f64,
    /// Seed of the heights.
    pub seed: u64,
}

impl Default for RandomTiles {
    fn default() -> Self {
        RandomTiles { size: TILE_SIZE, height: 0.0, seed: 1 }
    }
}

impl Ground {
    /// Whether every value is the default.
    pub fn is_default(&self) -> bool {
        *self == Ground::default()
    }

    /// Whether it is the plane z = 0.
    pub fn is_plane(&self) -> bool {
        self.tiles.is_empty() && self.random.height == 0.0
    }

    /// Height at the point (x, y) [m].
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let tile = self.tiles.iter().find(|tile| tile.covers(x, y));
        tile.map_or_else(|| self.random.height_at(x, y), |tile| tile.height)
    }
}

impl Ground {
    /// The tiles within this distance of the origin of W along x and y [m], for a drawing. Of random tiles, those whose centre is on no
    /// other tile, and at most [`DRAWN`] in each direction.
    pub fn tiles_within(&self, reach: f64) -> Vec<GroundTile> {
        let clipped = |[first, last]: [f64; 2]| [first.max(-reach), last.min(reach)];
        let given = self.tiles.iter().map(|tile| GroundTile { x: clipped(tile.x), y: clipped(tile.y), ..*tile });
        let mut drawn: Vec<_> = given.filter(|tile| tile.x[0] < tile.x[1] && tile.y[0] < tile.y[1]).collect();
        if self.random.height > 0.0 {
            let [rows, columns] = self.random.size.map(|side| (reach / side).ceil().min(DRAWN));
            let places = |count: f64| (-count as i64..count as i64).map(|place| place as f64);
            let edges = |place: f64, side: f64| clipped([place * side, (place + 1.0) * side]);
            for (i, j) in places(rows).flat_map(|i| places(columns).map(move |j| (i, j))) {
                let (x, y) = (edges(i, self.random.size[0]), edges(j, self.random.size[1]));
                let centre = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
                if !self.tiles.iter().any(|tile| tile.covers(centre[0], centre[1])) {
                    drawn.push(GroundTile { x, y, height: self.height(centre[0], centre[1]) });
                }
            }
        }
        drawn
    }
}

impl GroundTile {
    /// Whether the point (x, y) is on the tile. The first edge belongs to the tile, the last one does not.
    fn covers(&self, x: f64, y: f64) -> bool {
        let within = |[first, last]: [f64; 2], at: f64| first <= at && at < last;
        within(self.x, x) && within(self.y, y)
    }

    /// Whether two tiles overlap.
    pub fn overlaps(&self, other: &GroundTile) -> bool {
        let meet = |a: [f64; 2], b: [f64; 2]| a[0] < b[1] && b[0] < a[1];
        meet(self.x, other.x) && meet(self.y, other.y)
    }
}

impl RandomTiles {
    fn height_at(&self, x: f64, y: f64) -> f64 {
        if self.height == 0.0 {
            return 0.0;
        }
        let [i, j] = [x / self.size[0], y / self.size[1]].map(|place| place.floor() as i64 as u64);
        let mixed = mix(mix(mix(self.seed) ^ i) ^ j);
        let share = (mixed >> 11) as f64 / (1_u64 << 53) as f64; // from 0 to 1
        self.height * (2.0 * share - 1.0)
    }
}

/// A bijection whose results look random.
///
/// # Source
/// The finalizer of SplitMix64: Steele, Lea & Flood, *Fast splittable pseudorandom number generators* (2014).
fn mix(number: u64) -> u64 {
    let a = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let b = (a ^ (a >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let c = (b ^ (b >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    c ^ (c >> 31)
}

fn everywhere() -> [f64; 2] {
    EVERYWHERE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_has_its_height_within_its_edges_only() {
        let kerb = GroundTile { x: [1.0, 1.3], y: everywhere(), height: 0.01 };
        let ground = Ground { tiles: vec![kerb], ..Ground::default() };
        for (x, height) in [(0.9, 0.0), (1.0, 0.01), (1.29, 0.01), (1.3, 0.0)] {
            assert_eq!(ground.height(x, -7.0), height, "{x}");
        }
    }

    #[test]
    fn random_heights_fill_their_range_evenly_and_depend_on_place_and_seed() {
        let random = RandomTiles { size: [0.2, 0.3], height: 0.005, seed: 7 };
        let heights = |random: RandomTiles| -> Vec<f64> {
            let rows = (-50..50).flat_map(|i| (-50..50).map(move |j| (f64::from(i), f64::from(j))));
            rows.map(|(i, j)| random.height_at(0.2 * (i + 0.5), 0.3 * (j + 0.5))).collect()
        };
        let all = heights(random);
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        let variance = all.iter().map(|height| height * height).sum::<f64>() / count;
        assert!(all.iter().all(|height| height.abs() <= 0.005));
        assert!(mean.abs() < 1e-4 && (variance / (0.005_f64.powi(2) / 3.0) - 1.0).abs() < 0.05, "{mean}, {variance}");
        assert_eq!(random.height_at(0.01, 0.01), random.height_at(0.19, 0.29), "one tile has one height");
        assert_ne!(all, heights(RandomTiles { seed: 8, ..random }));
    }

    #[test]
    fn the_drawn_tiles_have_the_heights_of_their_places() {
        let level = GroundTile { x: [-1.0, 0.6], y: everywhere(), height: 0.002 };
        let ground = Ground { tiles: vec![level], random: RandomTiles { height: 0.005, ..RandomTiles::default() } };
        let drawn = ground.tiles_within(4.0);
        assert_eq!(drawn.len(), 1 + 40 * (40 - 8), "a row of eight tiles has its centre on the given tile");
        for GroundTile { x, y, height } in drawn {
            assert!(x[0] >= -4.0 && y[1] <= 4.0);
            assert_eq!(height, ground.height(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])));
        }
    }

    #[test]
    fn given_tiles_have_priority_over_random_ones() {
        let level = GroundTile { x: [-1.0, 0.5], y: everywhere(), height: 0.0 };
        let random = RandomTiles { height: 0.005, ..RandomTiles::default() };
        let ground = Ground { tiles: vec![level], random };
        assert_eq!(ground.height(0.3, 0.1), 0.0);
        assert_ne!(ground.height(0.5, 0.1), 0.0);
    }
}
