//! One macro that writes a product for all four combinations of values and references.

/// Implements `Mul` for `$left * $right` by value and by reference through one expression of two references.
macro_rules! impl_product {
    ($left:ty, $right:ty, $output:ty, |$a:ident, $b:ident| $body:expr) => {
        impl Mul<&$right> for &$left {
            type Output = $output;
            #[inline]
            fn mul(self, other: &$right) -> $output {
                let ($a, $b) = (self, other);
                $body
            }
        }
        impl Mul<$right> for &$left {
            type Output = $output;
            #[inline]
            fn mul(self, other: $right) -> $output {
                self * &other
            }
        }
        impl Mul<&$right> for $left {
            type Output = $output;
            #[inline]
            fn mul(self, other: &$right) -> $output {
                &self * other
            }
        }
        impl Mul<$right> for $left {
            type Output = $output;
            #[inline]
            fn mul(self, other: $right) -> $output {
                &self * &other
            }
        }
    };
}

pub(crate) use impl_product;
