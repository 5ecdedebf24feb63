//! Why a fact holds or does not, in words and numbers, for `sgap facts`.
