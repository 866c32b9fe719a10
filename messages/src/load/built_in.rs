//! The built-in scenes: the files of `messages/scenes`.

/// A built-in scene: its name and its TOML text.
pub type BuiltIn = (&'static str, &'static str);

/// All built-in scenes.
pub const SCENES: &[BuiltIn] = &[
    ("walk", include_str!("../../scenes/walk.toml")),
    ("stamp", include_str!("../../scenes/stamp.toml")),
    ("walk-literal", include_str!("../../scenes/walk-literal.toml")),
    ("paper", include_str!("../../scenes/paper.toml")),
    ("stand", include_str!("../../scenes/stand.toml")),
    // for the comparison with other simulators
    ("free", include_str!("../../scenes/free.toml")),
    ("slide", include_str!("../../scenes/slide.toml")),
    ("slide30", include_str!("../../scenes/slide30.toml")),
    ("incline", include_str!("../../scenes/incline.toml")),
    ("stick", include_str!("../../scenes/stick.toml")),
    ("drop", include_str!("../../scenes/drop.toml")),
    ("stand0", include_str!("../../scenes/stand0.toml")),
    ("stand10", include_str!("../../scenes/stand10.toml")),
    ("rock", include_str!("../../scenes/rock.toml")),
    ("wheel", include_str!("../../scenes/wheel.toml")),
    ("turn", include_str!("../../scenes/turn.toml")),
    ("ball", include_str!("../../scenes/ball.toml")),
    // with known solutions
    ("sliding-block", include_str!("../../scenes/known/sliding-block.toml")),
    ("fast-cube", include_str!("../../scenes/known/fast-cube.toml")),
    ("slope", include_str!("../../scenes/known/slope.toml")),
    ("roll", include_str!("../../scenes/known/roll.toml")),
    ("rocking-block", include_str!("../../scenes/known/rocking-block.toml")),
    ("squat-block", include_str!("../../scenes/known/squat-block.toml")),
    ("rimless-wheel", include_str!("../../scenes/known/rimless-wheel.toml")),
    ("simplest-walker", include_str!("../../scenes/known/simplest-walker.toml")),
    ("compass-gait", include_str!("../../scenes/known/compass-gait.toml")),
    ("painleve-rod", include_str!("../../scenes/known/painleve-rod.toml")),
    ("zeno", include_str!("../../scenes/known/zeno.toml")),
    ("flat-drop", include_str!("../../scenes/known/flat-drop.toml")),
    ("eight-corners", include_str!("../../scenes/known/eight-corners.toml")),
    ("pivot", include_str!("../../scenes/known/pivot.toml")),
    ("spinning-box", include_str!("../../scenes/known/spinning-box.toml")),
    ("gimbal", include_str!("../../scenes/known/gimbal.toml")),
    ("spring-ground", include_str!("../../scenes/known/spring-ground.toml")),
    ("stick-hour", include_str!("../../scenes/known/stick-hour.toml")),
    ("tumbling-foot", include_str!("../../scenes/known/tumbling-foot.toml")),
    ("double-pendulum", include_str!("../../scenes/known/double-pendulum.toml")),
    ("spinning-foot", include_str!("../../scenes/known/spinning-foot.toml")),
];
