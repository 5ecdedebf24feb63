//! Why a branch of the search failed: typed, with numbers.
