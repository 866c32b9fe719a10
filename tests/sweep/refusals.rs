//! Bad arguments of `biped sweep`.

use crate::common::{self, fresh_path};
use crate::output;

#[test]
fn a_bad_argument_is_refused_in_one_sentence() {
    let folder = fresh_path("sweep");
    let refused: [(&[&str], &[&str]); 27] = [
        (&["drop", "plant.fricton=0,1"], &["plant.fricton=0: ", "did you mean `friction`"]),
        (&["drop", "plant.friction"], &["plant.friction: ", "plant.friction=0.1:0.9:5"]),
        (&["drop", "plant.friction="], &["plant.friction=: ", "plant.friction=0.1:0.9:5"]),
        (&["drop", "plant.friction=1,,2"], &["two commas"]),
        (&["drop", "plant.friction=0:1"], &["0:1 is no range", "a:b:n"]),
        (&["drop", "plant.friction=0:1:1"], &["`1` values", "from 2 to 100000"]),
        (&["drop", "plant.friction=1:1:5"], &["1:1:5 is empty"]),
        (&["drop", "plant.friction=log:0:1:5"], &["logarithmic", "greater than 0"]),
        (&["drop", "plant.friction=0:-1:3"], &["plant.friction", "negative"]),
        (&["drop", "plant.friction=0,0"], &["plant.friction", "0 is given twice"]),
        (&["drop", "plant.friction=0,1", "plant.friction=2"], &["plant.friction", "given twice"]),
        (&["drop", "plant.friction=0,1", "--set", "plant.friction=2"], &["plant.friction", "given twice"]),
        (&["drop", "plant.friction=0,1", "--edge", "plant.friction=0:1"], &["plant.friction", "given twice"]),
        (
            &["drop", "plant.friction=0:1:1000", "plant.restitution=0:1:1000"],
            &["1000000 runs", " h on", "at most 100000"],
        ),
        (&["drop", "plant.encoder_bits=8:16:4"], &["plant.encoder_bits=", "a whole number"]),
        (&["drop", "seeds=3"], &["seeds", "nothing in drop is random"]),
        (&["walk", "seeds=0"], &["seeds=0", "from 1 to 1000"]),
        (&["walk", "seeds=2", "link.seed=1,2", "link.loss=0.1"], &["link.seed", "given twice"]),
        (&["walk", "seed=1,2"], &["seed", "seeds=N"]),
        (&["wlak", "duration=1,2"], &["wlak", "did you mean `walk`"]),
        (&["drop", "--edge", "plant.friction=0:1"], &["--edge", "no feet", "--survival"]),
        (&["walk", "--edge", "plant.friction=0,1"], &["--edge plant.friction=0,1", "one range"]),
        (&["walk", "--edge", "plant.encoder_bits=8:16:9"], &["plant.encoder_bits=8.5", "a whole number"]),
        (&["walk", "--edge", "plant.friction=0.1:1", "--tolerance", "-1"], &["--tolerance -1", "greater than 0"]),
        (&["drop", "duration=1,2", "--survival", "distnce_m<1"], &["`distnce_m`", "did you mean `distance_m`"]),
        (&["drop", "duration=1,2", "--survival", "distance_m<x"], &["--survival distance_m<x", "finite number"]),
        (&["drop", "duration=1,2", "--merge", "README.md"], &["README.md is the table of another sweep"]),
    ];
    common::assert_all_refused(|arguments| output(arguments, &folder), &refused);
    assert!(!folder.exists(), "a refused sweep left a folder");
    let misused: [(&[&str], &str); 3] = [
        (&["drop"], "KEY=RANGE"),
        (&["drop", "duration=1,2", "--shard", "3/2"], "i from 1 to n"),
        (&["drop", "duration=1,2", "--tolerance", "1"], "--edge"),
    ];
    common::assert_all_misused(|arguments| output(arguments, &folder), &misused);
}
