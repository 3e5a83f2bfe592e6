//! The points of the Sobol sequence and their scrambling, in integers; bits are in reversed order.

use super::mix;

/// Owen's scrambling of component `component` of a point whose bits are reversed.
#[inline(always)]
pub(super) fn scrambled(reversed: u32, key: u32, component: u32) -> u32 {
    permuted(reversed, mix(key.wrapping_add((component + 1).wrapping_mul(0x68e3_1da4)))).reverse_bits()
}

/// A random tree permutation: whether a bit flips depends on the key and on the bits below it.
///
/// Laine and Karras 2011, "Stratified sampling for stochastic transparency", in the form that Vegdahl 2021, "Building a
/// better LK hash", found to be free of correlations. The constants are the best of 250 drawn at random: over 511 nodes
/// of the tree, correlations of two nodes' flips are 1.015 times those of coin tosses, root mean square.
#[inline(always)]
pub(super) fn permuted(x: u32, key: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0xe635_a8d2);
    let x = x.wrapping_add(key).wrapping_mul(key >> 16 | 1);
    let x = x ^ x.wrapping_mul(0xb7ca_7496);
    x ^ x.wrapping_mul(0x57f2_267a)
}

/// The second Sobol dimension, bits reversed: Pascal's triangle modulo 2 is the fifth power (Kronecker's) of its corner
/// of two by two, and each factor takes one step.
#[inline(always)]
pub(super) fn pascal(index: u32) -> u32 {
    let x = index ^ index >> 16;
    let x = x ^ x >> 8 & 0x00ff_00ff;
    let x = x ^ x >> 4 & 0x0f0f_0f0f;
    let x = x ^ x >> 2 & 0x3333_3333;
    x ^ x >> 1 & 0x5555_5555
}

/// The third and the fourth Sobol dimension with the direction numbers of Joe and Kuo 2008: primitive polynomials
/// x² + x + 1 and x³ + x + 1.
pub(super) static SOBOL_3: [u32; 32] = sobol_columns(2, 1, [1, 3, 0]);
pub(super) static SOBOL_4: [u32; 32] = sobol_columns(3, 1, [1, 3, 1]);

/// The columns of a Sobol matrix, bits reversed, by Bratley and Fox 1988: a primitive polynomial's degree, its inner
/// coefficients, and the first direction numbers.
const fn sobol_columns(degree: usize, inner: u32, first: [u32; 3]) -> [u32; 32] {
    let mut columns = [0u32; 32];
    let mut i = 0;
    while i < 32 {
        columns[i] = if i < degree {
            first[i] << (31 - i)
        } else {
            let mut column = columns[i - degree] ^ columns[i - degree] >> degree;
            let mut k = 1;
            while k < degree {
                if inner >> (degree - 1 - k) & 1 != 0 {
                    column ^= columns[i - k];
                }
                k += 1;
            }
            column
        };
        i += 1;
    }
    let mut i = 0;
    while i < 32 {
        columns[i] = columns[i].reverse_bits();
        i += 1;
    }
    columns
}

/// A matrix over bits times an index.
#[inline(always)]
pub(super) fn product(columns: &[u32; 32], index: u32) -> u32 {
    let mut sum = 0;
    for (bit, column) in columns.iter().enumerate() {
        sum ^= column & (index >> bit & 1).wrapping_neg();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::unit;
    use super::*;

    /// Points 0 to 7 in natural order, worked out by hand from the direction numbers of Joe and Kuo's table: 1 1 1 …, 1 3 5 …,
    /// 1 3 3 …, 1 3 1 ….
    #[test]
    fn matrices_are_sobols() {
        let expected = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.25, 0.75, 0.75, 0.75],
            [0.75, 0.25, 0.25, 0.25],
            [0.125, 0.625, 0.375, 0.125],
            [0.625, 0.125, 0.875, 0.625],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
        ];
        for (index, expected) in (0..).zip(expected) {
            let point = [index, pascal(index), product(&SOBOL_3, index), product(&SOBOL_4, index)];
            assert_eq!(point.map(|reversed| unit(reversed.reverse_bits())), expected, "point {index}");
        }
        // The second dimension's direction numbers obey v = w ^ w/2, w the one before.
        for bit in 1..32 {
            let before = pascal(1 << (bit - 1)).reverse_bits();
            assert_eq!(pascal(1 << bit).reverse_bits(), before ^ before >> 1, "bit {bit}");
        }
    }

    #[test]
    fn a_permutation_flips_bits_by_the_bits_below() {
        for key in (0..1000).map(mix) {
            for bit in 0..32 {
                let (x, mask) = (mix(key ^ bit), u32::MAX.checked_shl(bit).unwrap_or(0));
                let differ = permuted(x, key) ^ permuted(x ^ 1 << bit, key);
                assert_eq!(differ & !mask, 0, "a bit above {bit} flipped one below");
                assert_eq!(differ & 1 << bit, 1 << bit, "bit {bit} must stay one to one");
            }
        }
    }
}
