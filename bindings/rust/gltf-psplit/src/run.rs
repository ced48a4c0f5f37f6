//! How calls run: threads, progress, and flags that end them.

use crate::error::{checked, Error};
use gltf_psplit_sys as sys;
use std::any::Any;
use std::os::raw::c_void;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::ptr::{null, null_mut, NonNull};
use std::sync::Mutex;

/// Threads that several calls use, one after the other or at once.
pub struct Pool(NonNull<sys::psplit_pool>);

// SAFETY: functions of C take a pool from any thread. Freeing it needs it alone, as drop has it.
unsafe impl Send for Pool {}
unsafe impl Sync for Pool {}

impl Pool {
    /// `threads` count the calling thread; 0 means one for each processor, and 4096 is the most.
    pub fn new(threads: u32) -> Result<Self, Error> {
        let threads = i32::try_from(threads).map_err(|_| Error::usage("too many threads"))?;
        let mut pool = null_mut();
        // SAFETY: both pointers are of places for results.
        checked(|error| unsafe { sys::psplit_pool_create(threads, &mut pool, error) })?;
        Ok(Self(NonNull::new(pool).expect("a new pool is not null")))
    }

    /// The number of threads, with the calling one.
    pub fn threads(&self) -> u32 {
        // SAFETY: the handle lives as long as self.
        unsafe { sys::psplit_pool_threads(self.0.as_ptr()) as u32 }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // SAFETY: calls that use the pool borrow it, so none does any more.
        unsafe { sys::psplit_pool_free(self.0.as_ptr()) }
    }
}

/// A flag that ends decoding or encoding, which then returns [`ErrorCode::Cancelled`](crate::ErrorCode::Cancelled).
pub struct Stop(NonNull<sys::psplit_stop>);

// SAFETY: the flag is atomic. Freeing it needs it alone, as drop has it.
unsafe impl Send for Stop {}
unsafe impl Sync for Stop {}

impl Stop {
    pub fn new() -> Result<Self, Error> {
        let mut stop = null_mut();
        // SAFETY: both pointers are of places for results.
        checked(|error| unsafe { sys::psplit_stop_create(&mut stop, error) })?;
        Ok(Self(NonNull::new(stop).expect("a new flag is not null")))
    }

    /// Sets the flag, from any thread, also while calls read it.
    pub fn set(&self, value: bool) {
        // SAFETY: the handle lives as long as self, and the flag is atomic.
        unsafe { sys::psplit_stop_set(self.0.as_ptr(), value.into()) }
    }
}

impl Drop for Stop {
    fn drop(&mut self) {
        // SAFETY: calls that read the flag borrow it, so none does any more.
        unsafe { sys::psplit_stop_free(self.0.as_ptr()) }
    }
}

/// How a call runs. The default is one thread for each processor.
#[derive(Clone, Copy, Default)]
pub struct Run<'a> {
    /// The threads of this call, if there is no pool; 0 means one for each processor.
    pub threads: u32,
    /// Threads of a pool. Reuse a pool for frequent calls.
    pub pool: Option<&'a Pool>,
    /// Ends the call when it is set.
    pub stop: Option<&'a Stop>,
    /// Called with the number of finished steps and their total, from any thread, also from several at once. Steps are
    /// patches where meshes are decoded, and faces where they are encoded.
    pub progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

impl<'a> Run<'a> {
    /// Runs on the calling thread alone.
    pub fn serial() -> Self {
        Self { threads: 1, ..Self::default() }
    }

    pub fn with_pool(pool: &'a Pool) -> Self {
        Self { pool: Some(pool), ..Self::default() }
    }

    pub(crate) fn thread_count(&self) -> i32 {
        i32::try_from(self.threads).unwrap_or(i32::MAX) // which C refuses
    }
    pub(crate) fn pool_pointer(&self) -> *const sys::psplit_pool {
        self.pool.map_or(null(), |pool| pool.0.as_ptr())
    }
    pub(crate) fn stop_pointer(&self) -> *const sys::psplit_stop {
        self.stop.map_or(null(), |stop| stop.0.as_ptr())
    }

    /// Gives `call` this value as C has it. If the callback panicked, so does this, after the call.
    pub(crate) fn with_c<R>(&self, call: impl FnOnce(&sys::psplit_run) -> R) -> R {
        with_progress(self.progress, |progress, user| {
            let mut run = sys::psplit_run::new();
            run.threads = self.thread_count();
            run.pool = self.pool_pointer();
            run.stop = self.stop_pointer();
            run.progress = progress;
            run.user = user;
            call(&run)
        })
    }
}

/// A callback, and the panic that it ended with.
struct Watched<'a> {
    callback: &'a (dyn Fn(usize, usize) + Sync),
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

/// Gives `call` the callback as C has it. A panic of the callback does not reach C: it is kept, and goes on here.
pub(crate) fn with_progress<R>(
    callback: Option<&(dyn Fn(usize, usize) + Sync)>,
    call: impl FnOnce(sys::psplit_progress, *mut c_void) -> R,
) -> R {
    let callback = match callback {
        Some(callback) => callback,
        None => return call(None, null_mut()),
    };
    let watched = Watched { callback, panic: Mutex::new(None) };
    let result = call(Some(report), &watched as *const Watched as *mut c_void);
    // No thread has it any more, and the lock is never held while something could panic.
    if let Some(panic) = watched.panic.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
        resume_unwind(panic);
    }
    result
}

unsafe extern "C" fn report(user: *mut c_void, done: usize, total: usize) {
    // SAFETY: `user` is what with_progress gave, which waits until no call is left. Watched is Sync.
    let watched = unsafe { &*(user as *const Watched) };
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (watched.callback)(done, total))) {
        let mut kept = watched.panic.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        match *kept {
            None => *kept = Some(panic),
            // The value of a panic may panic when it is dropped.
            Some(_) => std::mem::forget(panic),
        }
    }
}

/// Frees the memory that threads keep from one call to the next: for each, about what its largest stream took.
pub fn release_scratch() {
    // SAFETY: a function without arguments.
    unsafe { sys::psplit_release_scratch() }
}
