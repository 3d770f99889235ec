//! NumPy's file format, version 1.0, for visits.

/// `visits` as a little-endian `u32` array of shape `[rows, columns]` in C order.
pub fn visits_npy(visits: &[u32], [columns, rows]: [u32; 2]) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    // The header ends in a newline and the data begins at a multiple of 64 bytes.
    const ALIGNMENT: usize = 64;
    let mut header =
        format!("{{'descr': '<u4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let unpadded = MAGIC.len() + 2 + header.len() + 1;
    let padding = unpadded.next_multiple_of(ALIGNMENT) - unpadded;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');

    let mut bytes = Vec::with_capacity(unpadded + padding + 4 * visits.len());
    bytes.extend_from_slice(MAGIC);
    // A header of some 70 bytes, padded to less than 256.
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend(visits.iter().flat_map(|count| count.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_and_data_are_where_numpy_looks() {
        let bytes = visits_npy(&[0, 1, 2, 0x0102_0304], [2, 2]);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let header_bytes = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + header_bytes) % 64, 0);
        let header = String::from_utf8_lossy(&bytes[10..10 + header_bytes]);
        assert!(header.contains("'descr': '<u4'") && header.contains("'shape': (2, 2)"));
        assert!(header.ends_with('\n'));
        assert_eq!(
            &bytes[10 + header_bytes..],
            [0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 3, 2, 1]
        );
    }
}
