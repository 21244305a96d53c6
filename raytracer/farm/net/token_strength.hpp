#pragma once

#include <string>
#include <string_view>

namespace terravox::net {

inline constexpr double kMinToken_bits = 64;  ///< of estimated_bits()

/// How hard a token is to guess for somebody who has a proof made with it and tries tokens on that
/// (handshake.hpp): whoever a dialler is made to call gets one. The estimate is the sum over the
/// characters of what each adds for somebody who guesses well:
/// - 0.3 bits where it continues a copy of three characters or more that stood earlier in the
/// token, in either case;
/// - 0.5 bits from the third on that repeat or go on by steps of one in ASCII or on a keyboard's
/// row (aaa, abc, 321, qwe);
/// - 8 bits for all of a word that everybody tries first (password, farm, ...), written with digits
/// for letters or not;
/// - a letter after a letter 1.5 bits where the pair is frequent in English, else 4.7, and 1 bit
/// more where upper and lower case change;
///   any other letter 4.7;
/// - a digit 3.3, and 1.5 where it is of a year from 1900 to 2099;
/// - a space or punctuation 4, and 0.5 if it stood in the token before.
/// Random letters and digits have about 4 bits each by this, English words 2, and words chosen at
/// random by dice about what they truly have.
[[nodiscard]] double estimated_bits(std::string_view token);

/// @return why the token will not do, with a way to a better one; empty: it will
[[nodiscard]] std::string weakness_of(std::string_view token);

}  // namespace terravox::net
