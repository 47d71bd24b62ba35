/// A set of particles as bits. It is small enough to stay in the cache.
#[derive(Debug, Clone, Default)]
pub struct Marks(Vec<u64>);

impl Marks {
    #[inline]
    pub fn has(&self, particle: u32) -> bool {
        self.0.get(particle as usize / 64).is_some_and(|marks| marks >> (particle % 64) & 1 != 0)
    }

    pub fn put(&mut self, particle: u32, is_in: bool) {
        let at = particle as usize / 64;
        if at >= self.0.len() {
            self.0.resize(at + 1, 0);
        }
        self.0[at] = self.0[at] & !(1 << (particle % 64)) | u64::from(is_in) << (particle % 64);
    }
}
