//! One labelled picture of many images: the terms of the image by path length, or Veach's pyramid of techniques.
//!
//! Pictures hang in rows, each with a line of text above it and each row with one at its left, on a white page. They are brought to a common size by whole
//! factors: small ones are magnified until their labels fit, and all are averaged down until the page is no wider or higher
//! than 8192 pixels.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_10X20;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::text::{Baseline, Text};

use crate::film::{FilmError, Image};
use crate::spectrum::Rgb;

/// An image with the text above it. Its values are displayed as they are: 1 is white.
#[derive(Clone, Debug)]
pub struct Picture {
    /// One line of text.
    pub label: String,
    /// Linear colours.
    pub image: Image,
}

/// A row of pictures.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// One line of text at its left, or none.
    pub title: String,
    /// From left to right.
    pub pictures: Vec<Picture>,
}

/// Size of a letter of the font in pixels.
const LETTER: (u32, u32) = (10, 20);

/// Space between two pictures in pixels.
const GAP: u32 = 12;

/// Longest side of the page in pixels.
const LONGEST: u32 = 8192;

/// The largest power of two, at least 1, with which `image` is no brighter than `reference`, both as displayed: by the mean
/// of their luminance, clipped at 1. It stops before a doubling that no longer makes the image brighter by half.
#[must_use]
pub fn auto_gain(image: &Image, reference: &Image) -> f64 {
    let displayed = |image: &Image, gain: f64| {
        let clipped = image.pixels.iter().map(|pixel| (gain * pixel.luminance()).clamp(0.0, 1.0));
        clipped.sum::<f64>() / image.pixels.len() as f64
    };
    let limit = displayed(reference, 1.0);
    let mut gain = 1.0;
    loop {
        let (now, next) = (displayed(image, gain), displayed(image, 2.0 * gain));
        if !(next <= limit && next >= 1.5 * now && now > 0.0) {
            return gain;
        }
        gain *= 2.0;
    }
}

/// The page with these rows, each centred. All pictures are of one size.
///
/// # Errors
/// When there are none, or sizes differ, or there are so many that no page holds them.
pub fn page(rows: &[Row]) -> Result<Image, FilmError> {
    let pictures = || rows.iter().flat_map(|row| &row.pictures);
    let first = pictures().next().ok_or(FilmError::Size { width: 0, height: 0 })?;
    let (width, height) = (first.image.width, first.image.height);
    if pictures().any(|picture| (picture.image.width, picture.image.height) != (width, height)) {
        return Err(FilmError::Incompatible);
    }
    let length = |text: &str| text.chars().count() as u32 * LETTER.0;
    let columns = rows.iter().map(|row| row.pictures.len()).max().unwrap_or(1) as u32;
    let widest = |side: u32, count: usize| side.saturating_mul(count as u32).div_ceil(LONGEST).max(1);
    let down = widest(width, columns as usize).max(widest(height, rows.len()));
    let small = (width.div_ceil(down), height.div_ceil(down));
    let up = pictures().map(|picture| length(&picture.label)).max().unwrap_or(1).div_ceil(small.0).max(1);
    let cell = (small.0 * up, LETTER.1 + GAP / 2 + small.1 * up);
    let margin = match rows.iter().map(|row| length(&row.title)).max() {
        None | Some(0) => GAP,
        Some(title) => title + 2 * GAP,
    };
    let across = |count: usize| (count as u32 * (cell.0 + GAP)).saturating_sub(GAP);
    let size = (margin + across(columns as usize) + GAP, GAP + rows.len() as u32 * (cell.1 + GAP));
    let mut page = Page(Image::constant(size.0, size.1, Rgb::WHITE)?);
    for (index, row) in rows.iter().enumerate() {
        let top = GAP + index as u32 * (cell.1 + GAP);
        let under = top + LETTER.1 + GAP / 2;
        page.write(&row.title, GAP, under + (cell.1 - (under - top)).saturating_sub(LETTER.1) / 2);
        let left = margin + (across(columns as usize) - across(row.pictures.len())) / 2;
        for (column, picture) in row.pictures.iter().enumerate() {
            let left = left + column as u32 * (cell.0 + GAP);
            page.write(&picture.label, left + (cell.0 - length(&picture.label)) / 2, top);
            page.hang(&picture.image, left, under, down, up);
        }
    }
    Ok(page.0)
}

/// The picture that is being made.
struct Page(Image);

impl Page {
    fn write(&mut self, text: &str, left: u32, top: u32) {
        let style = MonoTextStyle::new(&FONT_10X20, BinaryColor::On);
        let place = Point::new(left as i32, top as i32);
        // Drawing on pixels in memory cannot fail.
        let _: Result<Point, Infallible> = Text::with_baseline(text, place, style, Baseline::Top).draw(self);
    }

    /// Averages `down` × `down` pixels into one, and makes `up` × `up` of it.
    fn hang(&mut self, image: &Image, left: u32, top: u32, down: u32, up: u32) {
        for y in 0..image.height.div_ceil(down) {
            for x in 0..image.width.div_ceil(down) {
                let block = (0..down).flat_map(|dy| (0..down).map(move |dx| (x * down + dx, y * down + dy)));
                let (mut sum, mut count) = (Rgb::BLACK, 0.0);
                for value in block.filter_map(|(x, y)| image.get(x, y)) {
                    sum += value;
                    count += 1.0;
                }
                for (dx, dy) in (0..up).flat_map(|dy| (0..up).map(move |dx| (dx, dy))) {
                    self.set(left + x * up + dx, top + y * up + dy, sum / count);
                }
            }
        }
    }

    fn set(&mut self, x: u32, y: u32, value: Rgb) {
        let index = y as usize * self.0.width as usize + x as usize;
        if let Some(pixel) = self.0.pixels.get_mut(index).filter(|_| x < self.0.width) {
            *pixel = value;
        }
    }
}

impl OriginDimensions for Page {
    fn size(&self) -> Size {
        Size::new(self.0.width, self.0.height)
    }
}

impl DrawTarget for Page {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, _) in pixels {
            if let (Ok(x), Ok(y)) = (x.try_into(), y.try_into()) {
                self.set(x, y, Rgb::BLACK);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, value: f64) -> Image {
        Image::constant(width, height, Rgb::grey(value)).unwrap()
    }

    fn picture(label: &str, image: Image) -> Picture {
        Picture { label: label.into(), image }
    }

    #[test]
    fn gains_are_powers_of_two_up_to_the_reference_and_no_more_than_helps() {
        assert_eq!(auto_gain(&grey(4, 4, 0.09), &grey(4, 4, 0.8)), 8.0);
        assert_eq!(auto_gain(&grey(4, 4, 0.9), &grey(4, 4, 0.8)), 1.0);
        assert_eq!(auto_gain(&grey(4, 4, 0.0), &grey(4, 4, 0.8)), 1.0);
        // A lamp that is white already, in the dark: no gain shows more of it.
        let lamp = Image::from_fn(4, 4, |x, y| Rgb::grey(if x + y == 0 { 17.0 } else { 0.0 })).unwrap();
        assert_eq!(auto_gain(&lamp, &grey(4, 4, 0.8)), 1.0);
    }

    fn row(title: &str, pictures: Vec<Picture>) -> Row {
        Row { title: title.into(), pictures }
    }

    #[test]
    fn small_pictures_are_magnified_below_their_labels_and_rows_are_centred() {
        let grey_row = |n: usize| row("", vec![picture("s=2 t=3", grey(9, 5, 0.25)); n]);
        let one_and_two = page(&[grey_row(1), grey_row(2)]).unwrap();
        let (width, height) = (one_and_two.width, one_and_two.height);
        assert_eq!((width, height), (2 * (72 + 12) + 12, 2 * (40 + 26 + 12) + 12));
        let filled = |y: u32| {
            let is_grey = |x: &u32| one_and_two.get(*x, y) == Some(Rgb::grey(0.25));
            (0..width).filter(is_grey).collect::<Vec<_>>()
        };
        assert_eq!(filled(12 + 26), (54..126).collect::<Vec<_>>());
        assert_eq!(filled(12 + 26 + 78).len(), 144);
        let black = one_and_two.pixels.iter().filter(|pixel| pixel.is_black()).count();
        assert!(black > 100 && black % 3 == 0, "three times the same text: {black}");
        let titled = page(&[row("L_1", vec![picture("", grey(9, 5, 0.25))])]).unwrap();
        assert_eq!(titled.width, 12 + 30 + 12 + 9 + 12);
        assert!(titled.pixels.iter().any(|pixel| pixel.is_black()));
    }

    #[test]
    fn pages_that_would_be_too_large_are_averaged_down() {
        let stripes = Image::from_fn(4000, 2, |x, _| Rgb::grey(f64::from(x % 2))).unwrap();
        let three = ["a", "b", "c"].map(|label| picture(label, stripes.clone()));
        let page = page(&[row("", three.to_vec())]).unwrap();
        assert_eq!(page.width, 3 * 2012 + 12);
        assert_eq!(page.get(20, 12 + 26), Some(Rgb::grey(0.5)));
    }

    #[test]
    fn nothing_and_unequal_sizes_are_refused() {
        assert!(page(&[]).is_err() && page(&[Row::default()]).is_err());
        assert!(page(&[row("", vec![picture("a", grey(2, 2, 1.0)), picture("b", grey(2, 3, 1.0))])]).is_err());
    }
}
