//! The shorter part of the quick form: the default solver against everything but the slower piles. `rockfall validate --quick` is the whole of it.

use rockfall_validate::{Choice, EngineName, run};

/// Cases that the default solver does not pass today, and what is wrong. A case that comes to be passed has to leave this list.
const KNOWN: [(&str, &str); 5] = [
    (
        "gyroscope-contact",
        "an ellipsoid's tips are pushed out of the slope, which lifts it by some millimetres",
    ),
    ("bullets", "what was stopped deep in each other is pushed apart, and keeps the speed"),
    ("overhang", "contacts of 60 Hz let the lowest edges sink, which tilts a tall stack"),
    ("tower", "contacts of 60 Hz are too soft for a column of twenty"),
    ("small-column", "contacts of 60 Hz give by more than a hundredth of a ball of 5 mm"),
];

/// Promise: all cases of flight, friction, impact and statics, and the plate with 25 balls, come out as they have to, but for those that are known
/// not to; and those still don't.
#[test]
fn known_answers_are_met_but_for_known_failures() {
    let groups = ["rolling-y", "rolling-60", "flight", "friction", "impact", "statics"];
    let only = groups.map(str::to_owned).to_vec();
    let choice = Choice { only, quick: true, engines: vec![EngineName::SoftStep] };
    let report = run(&choice, |_| {}).expect("the cases are there");
    println!("{}\n{}", report.table(), report.summary());
    assert_eq!(report.failed(EngineName::SoftStep), KNOWN.map(|(case, _)| case));
}
