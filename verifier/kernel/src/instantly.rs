//! Jumps that a stretch begins with: where an urgent edge is due at all states of a landing, no time passes (LANGUAGE S8).
//!
//! Facts used: an edge is due where its guard holds as written and its reset leads into the domain of its target. Then it
//! fires, or another edge does that is enabled at the same states. No segment of flow is recorded: the only instant of
//! such a stretch is the landing, which is judged with the jump that led there.

use crate::fault::Fault;
use crate::hybrid::{Analysis, End};
use crate::series::values;
use crate::walk::{all, ranges, Walk};

impl<'a> Analysis<'a> {
    /// Make the jumps of a stretch that certainly dwells nowhere; `None` where it is no landing, or time may pass.
    pub(crate) fn jumped_at_once(&mut self, walk: &Walk<'a>) -> Result<Option<End>, Fault> {
        let mode = walk.mode;
        if walk.stretch.jump.is_none() || !mode.edges.iter().any(|e| e.is_urgent) {
            return Ok(None);
        }
        let set = walk.set()?;
        let watched = ranges(&set, &values(&set.space, &mode.watch, &set.models)?)?;
        let Some(known) = mode.kept(&watched) else { return Ok(None) };
        let is_sure = |number: usize| all(&mode.edges[number].guard, &known) == Some(true);
        // A run that may leave the declared ranges is followed by segments, which say so.
        if mode.window.truth(&watched) != Some(true)
            || !(0..mode.edges.len()).any(|e| mode.edges[e].is_urgent && is_sure(e))
        {
            return Ok(None);
        }
        let (mut landings, mut is_forced) = (Vec::new(), false);
        for number in (0..mode.edges.len()).filter(|&e| all(&walk.due_guard(e), &known) != Some(false)) {
            if let Some(landing) = self.landing(walk, number, &set, is_sure(number))? {
                is_forced |= mode.edges[number].is_urgent && landing.is_certain;
                landings.push(landing);
            }
        }
        if !is_forced {
            return Ok(None);
        }
        landings.into_iter().for_each(|l| self.leave(walk, l));
        Ok(Some(End::Jumped { may_be_stuck: false }))
    }
}
