//! Things that move: boxes contain them at every time, keyframes are exact, and what no inverse follows is refused.

mod bounds;
mod data;
mod motion;
mod scenes;

use crate::Case;

pub(crate) const CASES: &[Case] = &[
    Case { id: "A01", title: "translation only", run: bounds::translation },
    Case { id: "A02", title: "turns by 0.1 to 3.6 degrees, up to 10^6 from the axis", run: bounds::small_turns },
    Case { id: "A03", title: "turns by 4 to 179.9 degrees, off-center", run: bounds::large_turns },
    Case { id: "A04", title: "half turns and antipodal quaternions", run: bounds::half_turns },
    Case { id: "A05", title: "2 to 16 keyframes at uneven times", run: bounds::many_keyframes },
    Case { id: "A06", title: "a scale that goes through zero", run: data::through_zero },
    Case { id: "A07", title: "equal, odd and outside times", run: data::odd_times },
    Case { id: "A08", title: "motion in instances in motion", run: scenes::nested },
    Case { id: "A09", title: "sheared matrices, decomposed and recomposed", run: data::decomposed },
    Case { id: "A10", title: "what stands still, said to move", run: scenes::standing },
    Case { id: "A11", title: "boxes of a part of the time", run: bounds::shutter },
];
