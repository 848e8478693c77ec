//! Numpy arrays as images, without a copy where their rows allow it.

use dsslam::{DepthView, ImageView, PixelFormat};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;

use crate::arguments;

/// The format of color images whose channels have the order of a word.
pub(crate) fn color(word: &str) -> PyResult<PixelFormat> {
    arguments::choice("color", word, [("rgb", PixelFormat::Rgb8), ("bgr", PixelFormat::Bgr8)])
}

/// An array's pixels, borrowed from it. The array is kept alive; who writes into it during a call gets a mixed image.
pub(crate) struct Pixels<'py> {
    array: Bound<'py, PyArrayDyn<u8>>,
    width: usize,
    height: usize,
    layout: Layout,
}

/// How the bytes of an array lie, if images can be read from them as they lie.
struct Layout {
    /// From the array's first byte to the first that is read.
    offset: isize,
    stride: usize,
    format: PixelFormat,
}

impl<'py> Pixels<'py> {
    /// An image of shape (height, width), (height, width, 1) or (height, width, 3), uint8; `name` is that of the argument.
    pub(crate) fn of(array: &Bound<'py, PyAny>, name: &str, color: PixelFormat) -> PyResult<Self> {
        let array = bytes_of(array, name)?;
        let (height, width, channels) = match *array.shape() {
            [height, width] => (height, width, 1),
            [height, width, channels @ (1 | 3)] => (height, width, channels),
            ref shape => {
                let expected = "(height, width) or (height, width, 3)";
                return Err(wrong_shape(name, shape, expected));
            }
        };
        let (array, layout) = match layout(&array, width, channels, color) {
            Some(layout) => (array, layout),
            None => {
                let copy = contiguous(array.as_any())?.cast_into()?;
                let stride = width * channels;
                let format = if channels == 1 { PixelFormat::Gray8 } else { color };
                (copy, Layout { offset: 0, stride, format })
            }
        };
        Ok(Self { array, width, height, layout })
    }

    /// A mask of shape (height, width), uint8 or bool.
    pub(crate) fn of_mask(array: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        let is_bool = dtype(array).is_some_and(|kind| kind == "bool");
        let bytes = if is_bool { &array.call_method1("view", ("uint8",))? } else { array };
        let pixels = Self::of(bytes, name, PixelFormat::Rgb8)?;
        if pixels.layout.format == PixelFormat::Gray8 {
            return Ok(pixels);
        }
        Err(wrong_shape(name, pixels.array.shape(), "(height, width)"))
    }

    /// The image as the library takes it.
    pub(crate) fn view(&self) -> ImageView<'_> {
        let Layout { offset, stride, format } = self.layout;
        let bytes = if format == PixelFormat::Gray8 { 1 } else { 3 };
        let length = self.height.saturating_sub(1) * stride + self.width * bytes;
        let data: &[u8] = if self.height == 0 || self.width == 0 {
            &[]
        } else {
            // SAFETY: `layout` has checked that all strides are positive but, perhaps, that of the channels, which `offset` makes up
            // for; the last byte read is that of the last pixel, which the array owns and keeps alive.
            unsafe { std::slice::from_raw_parts(self.array.data().cast_const().offset(offset), length) }
        };
        ImageView::new(data, self.width, self.height, format).with_stride(stride)
    }
}

/// How the bytes lie; `None` where they have to be copied.
fn layout(
    array: &Bound<'_, PyArrayDyn<u8>>,
    width: usize,
    channels: usize,
    color: PixelFormat,
) -> Option<Layout> {
    let strides = array.strides();
    let stride = usize::try_from(strides[0]).ok().filter(|&stride| stride >= width * channels)?;
    match (channels, strides[1], strides.get(2)) {
        (1, 1, _) => Some(Layout { offset: 0, stride, format: PixelFormat::Gray8 }),
        (3, 3, Some(1)) => Some(Layout { offset: 0, stride, format: color }),
        // Channels turned round, as `image[:, :, ::-1]`.
        (3, 3, Some(-1)) => {
            let reversed = if color == PixelFormat::Rgb8 { PixelFormat::Bgr8 } else { PixelFormat::Rgb8 };
            Some(Layout { offset: -2, stride, format: reversed })
        }
        _ => None,
    }
}

/// Depth of an array.
pub(crate) enum Depth<'py> {
    /// In units of the configuration.
    Units(Bound<'py, PyArrayDyn<u16>>),
    /// In meters.
    Meters(Bound<'py, PyArrayDyn<f32>>),
}

impl<'py> Depth<'py> {
    /// Depth of shape (height, width): uint16 in units of the configuration, or float32 or float64 in meters.
    pub(crate) fn of(array: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        let kind = dtype(array).ok_or_else(|| wrong_type(array, name, "uint16 or float32"))?;
        let shape = array.cast::<PyUntypedArray>()?.shape().to_vec();
        if shape.len() != 2 {
            return Err(wrong_shape(name, &shape, "(height, width)"));
        }
        match kind.as_str() {
            "uint16" => Ok(Self::Units(contiguous(array)?.cast_into()?)),
            "float32" => Ok(Self::Meters(contiguous(array)?.cast_into()?)),
            "float64" => {
                Ok(Self::Meters(contiguous(&array.call_method1("astype", ("float32",))?)?.cast_into()?))
            }
            found => {
                Err(PyTypeError::new_err(format!("{name}: found dtype {found}, expected uint16 or float32")))
            }
        }
    }

    /// The depth as the library takes it.
    pub(crate) fn view(&self) -> DepthView<'_> {
        // SAFETY: `contiguous` has made the arrays contiguous, and they are kept alive.
        unsafe {
            match self {
                Depth::Units(array) => {
                    DepthView::u16(array.as_slice().unwrap_or(&[]), array.shape()[1], array.shape()[0])
                }
                Depth::Meters(array) => {
                    DepthView::meters(array.as_slice().unwrap_or(&[]), array.shape()[1], array.shape()[0])
                }
            }
        }
    }
}

/// Name of an array's element type; `None` for what is not an array.
fn dtype(array: &Bound<'_, PyAny>) -> Option<String> {
    let array = array.cast::<PyUntypedArray>().ok()?;
    array.getattr("dtype").and_then(|dtype| dtype.getattr("name")).and_then(|name| name.extract()).ok()
}

fn bytes_of<'py>(array: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
    array.cast::<PyArrayDyn<u8>>().cloned().map_err(|_| wrong_type(array, name, "uint8"))
}

fn wrong_type(array: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    let found = match dtype(array) {
        Some(kind) => format!("dtype {kind}"),
        None => array.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string()),
    };
    PyTypeError::new_err(format!("{name}: found {found}, expected a numpy array of {expected}"))
}

fn wrong_shape(name: &str, shape: &[usize], expected: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: found shape {shape:?}, expected {expected}"))
}

/// The array, or a copy whose values follow one another.
fn contiguous<'py>(array: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = array.py();
    py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "ascontiguousarray"), (array,))
}
