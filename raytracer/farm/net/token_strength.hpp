#pragma once

#include <string>
#include <string_view>

namespace terravox::net {

inline constexpr double kMinToken_bits = 64;  ///< of estimated_bits()

/// How hard a token is to guess for an attacker that has a proof made with it and tries tokens on
/// that (handshake.hpp): any listener that a dialler can be made to call gets such a proof. The
/// estimate is the sum over the characters of what each adds for a skilled attacker:
/// - 0.3 bits where it continues a copy of at least three earlier characters of the token, in
///   either case;
/// - 0.5 bits from the third character on of a repetition, or of a sequence in steps of one in
///   ASCII or on a keyboard's row (aaa, abc, 321, qwe);
/// - 8 bits for all of a commonly tried word (password, farm, ...), whether or not written with
///   digits for letters;
/// - a letter after a letter 1.5 bits where the pair is frequent in English, else 4.7, and 1 bit
///   more where upper and lower case change; any other letter 4.7;
/// - a digit 3.3, or 1.5 in a year from 1900 to 2099;
/// - a space or punctuation 4, or 0.5 if it occurred in the token before.
/// Random letters and digits have about 4 bits each by this measure, English words 2, and words
/// chosen at random by dice about their true entropy.
[[nodiscard]] double estimated_bits(std::string_view token);

/// @return why the token is too weak, with advice for a better one; empty: it is strong enough
[[nodiscard]] std::string weakness_of(std::string_view token);

}  // namespace terravox::net
