//! Which device an object belongs to.
//!
//! wgpu numbers devices, buffers and all else by instance. So the first device of one instance equals the first of another, their first
//! buffers are equal too, and a command that mixes the two takes whatever has the number. What a renderer with an instance for each
//! window does by mistake would then be a wrong picture or a panic far away. A home tells such devices apart.
//!
//! *How*: an error goes to the innermost error scope of its own device. With a scope of one device around a scope of the other, an error of
//! the outer one's device ends in the inner scope only if the two devices are one.
//!
//! *Guarantees*: homes are equal if and only if their devices are one, on every native backend. Comparing costs nothing. A device is not held
//! longer than by the objects that live there. In a browser, where scopes answer later, wgpu's own comparison is by identity and enough.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

use crate::scope;

/// The devices on which anything of this crate lives, each with its number.
static KNOWN: Mutex<Vec<(u64, std::sync::Weak<Number>, wgpu::Device)>> = Mutex::new(Vec::new());

/// A device, for the objects that live on it to compare.
#[derive(Clone, Debug)]
pub(crate) struct Home(Arc<Number>);

#[derive(Debug)]
struct Number(u64);

impl Home {
    /// The home of all that is made with a device.
    pub(crate) fn of(device: &wgpu::Device) -> Home {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        // homes of other devices: whoever held one may have let go of it meanwhile, and its end takes the lock
        let mut others = Vec::new();
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let same = known.iter().find_map(|(_, home, other)| {
            let home = home.upgrade()?;
            if other == device && scope::is_same(other, device) {
                return Some(home);
            }
            others.push(home);
            None
        });
        let home = match same {
            Some(number) => Home(number),
            None => {
                let number = NEXT.fetch_add(1, Ordering::Relaxed);
                let home = Arc::new(Number(number));
                known.push((number, Arc::downgrade(&home), device.clone()));
                Home(home)
            }
        };
        drop(known);
        drop(others);
        home
    }
}

impl PartialEq for Home {
    fn eq(&self, other: &Home) -> bool {
        self.0.0 == other.0.0
    }
}

impl Drop for Number {
    fn drop(&mut self) {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let at = known.iter().position(|(number, _, _)| *number == self.0);
        let last = at.map(|at| known.swap_remove(at));
        // the device's end may call back to its owner: not under the lock
        drop(known);
        drop(last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::gpu::Gpu;

    /// Two threads, each with a device of its own, of which the other's home ends again and again while it is looked for: it must not end
    /// under the lock that its end takes.
    #[test]
    fn homes_come_and_go_on_several_threads() {
        let devices: Vec<wgpu::Device> = (0..2)
            .map(|_| Gpu::open(None).expect("a driver").device)
            .collect();
        std::thread::scope(|scope| {
            for (own, other) in [(0, 1), (1, 0), (0, 1)] {
                let devices = &devices;
                scope.spawn(move || {
                    for _ in 0..2000 {
                        let home = Home::of(&devices[own]);
                        assert_eq!(home, Home::of(&devices[own]));
                        assert_ne!(home, Home::of(&devices[other]));
                    }
                });
            }
        });
    }
}
