//! Files to entities.
