/* 1 where the program is watched by a sanitizer of addresses or of threads, which takes several times the
 * memory and the time, reserves terabytes of addresses, and tells of crashes itself. */
#pragma once

#if defined __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SL_SANITIZED 1
#endif
#endif
#if !defined SL_SANITIZED && (defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__)
#define SL_SANITIZED 1
#endif
#ifndef SL_SANITIZED
#define SL_SANITIZED 0
#endif
