//! Orders and news.
