//! How much a sweep does.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// How much is done of everything: `--quick`, the default, `--full`.
pub struct Effort {
    pub rays: u32,
    pub judged_rays: u32,
    pub rounds: Rounds,
    pub pictures: PictureSizes,
}

/// How large pictures are, in pixels and samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PictureSizes {
    /// Of heat maps.
    pub map: [u32; 2],
    /// Of maps of leaks.
    pub leaks: [u32; 2],
    /// Of the ambient occlusion that is timed.
    pub occlusion: [u32; 2],
    /// Samples a pixel of the last image; those before have 1, 2, 4 and so on.
    pub samples: u32,
    /// Samples a pixel of the image that the others are compared with.
    pub reference_samples: u32,
}

/// How many rounds are timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounds {
    /// At least these, whatever they take.
    pub least: u32,
    /// At most these, while there is time.
    pub most: u32,
    /// From the start of the sweep of a scene on.
    pub budget: Duration,
}

pub const QUICK: Effort = Effort {
    rays: 1 << 12,
    judged_rays: 128,
    rounds: Rounds { least: 1, most: 9, budget: Duration::from_secs(10) },
    pictures: PictureSizes {
        map: [192, 120],
        leaks: [240, 240],
        occlusion: [48, 30],
        samples: 16,
        reference_samples: 256,
    },
};
pub const USUAL: Effort = Effort {
    rays: 1 << 15,
    judged_rays: 1024,
    rounds: Rounds { least: 3, most: 15, budget: Duration::from_secs(75) },
    pictures: PictureSizes {
        map: [288, 180],
        leaks: [400, 400],
        occlusion: [96, 60],
        samples: 64,
        reference_samples: 1024,
    },
};
pub const FULL: Effort = Effort {
    rays: 1 << 18,
    judged_rays: 1 << 14,
    rounds: Rounds { least: 9, most: 9, budget: Duration::ZERO },
    pictures: PictureSizes {
        map: [480, 300],
        leaks: [400, 400],
        occlusion: [96, 60],
        samples: 256,
        reference_samples: 4096,
    },
};
