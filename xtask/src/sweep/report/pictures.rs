//! Pictures of the report: heat maps at one colour scale, and maps of leaks.

use anyhow::Result;

use super::super::results::{LeakMaps, PictureAnswers};
use crate::picture::{heat, png_bytes};

/// Leaks: a colour that no surface has here, apart from grey for everybody.
const MAGENTA: [u8; 3] = [255, 0, 200];

/// A picture with its name as a file.
pub struct Picture {
    pub name: String,
    pub size: [u32; 2],
    pub png: Vec<u8>,
}

/// Where the colour scale of these heat maps ends: where all but one pixel in two hundred are, in each of them.
pub fn scale_end<'a>(pictures: impl Iterator<Item = &'a PictureAnswers>) -> u32 {
    let end = |picture: &PictureAnswers| {
        let mut sorted = picture.visits.clone();
        sorted.sort_unstable();
        sorted.get((sorted.len().max(1) - 1) - sorted.len() / 200).copied().unwrap_or(1)
    };
    pictures.map(end).max().unwrap_or(1).max(1)
}

/// Nodes visited, as colours up to `end`.
pub fn heat_map(name: &str, picture: &PictureAnswers, end: u32) -> Result<Picture> {
    let pixels: Vec<[u8; 3]> = picture.visits.iter().map(|&v| heat(v as f32 / end as f32)).collect();
    named(format!("visits-{name}.png"), picture.size, &pixels)
}

/// The surface in grey, and in magenta where rays of these kernels do not see it.
pub fn leak_map(maps: &LeakMaps, kernels: usize) -> Result<Picture> {
    let map = &maps.kernels[kernels];
    let pixel = |(&shade, &missed): (&u8, &u8)| if missed > 0 { MAGENTA } else { [shade, shade, shade] };
    let pixels: Vec<[u8; 3]> = maps.shade.iter().zip(&map.missed).map(pixel).collect();
    let ([left, top], size) = part_with_surface(maps);
    let rows = (top..top + size[1]).map(|y| (y * maps.size[0] + left) as usize);
    let part: Vec<[u8; 3]> = rows.flat_map(|start| pixels[start..start + size[0] as usize].iter().copied()).collect();
    named(format!("leaks-{}.png", map.kernels), size, &part)
}

/// Where there is something to be seen: the upper left corner, and the size.
fn part_with_surface(maps: &LeakMaps) -> ([u32; 2], [u32; 2]) {
    let seen = (0..).zip(&maps.shade).filter(|(_, shade)| **shade > 0);
    let places = seen.map(|(i, _): (u32, _)| [i % maps.size[0], i / maps.size[0]]);
    let (low, high) = places.fold(([u32::MAX; 2], [0; 2]), |(low, high): ([u32; 2], [u32; 2]), place| {
        ([0, 1].map(|a| low[a].min(place[a])), [0, 1].map(|a| high[a].max(place[a])))
    });
    if low[0] > high[0] {
        return ([0, 0], maps.size);
    }
    let margin = 4;
    let from = low.map(|x| x.saturating_sub(margin));
    let to = [0, 1].map(|a| (high[a] + margin + 1).min(maps.size[a]));
    (from, [to[0] - from[0], to[1] - from[1]])
}

fn named(name: String, size: [u32; 2], pixels: &[[u8; 3]]) -> Result<Picture> {
    Ok(Picture { name, size, png: png_bytes(size[0], size[1], pixels)? })
}
