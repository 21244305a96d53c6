#include "raytracer/farm/net/token_strength.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/util/letter_case.hpp"
#include "raytracer/farm/net/credentials.hpp"

namespace terravox::net {
namespace {

constexpr double kCopied_bits = 0.3;
constexpr double kRun_bits = 0.5;
constexpr double kWord_bits = 8;
constexpr double kFrequentPair_bits = 1.5;
constexpr double kLetter_bits = 4.7;
constexpr double kCase_bits = 1;
constexpr double kDigit_bits = 3.3;
constexpr double kYear_bits = 1.5;
constexpr double kSign_bits = 4;
constexpr double kSameSign_bits = 0.5;
constexpr std::size_t kMinCopy = 3;
constexpr std::size_t kYearDigits = 4;

/// Pairs of letters that English has most of, in words of all kinds.
constexpr std::string_view kPairs =
    "th he in er an re nd at on nt ha es st en ed to it ou ea hi is or ti as te et ng of al de se "
    "le sa si ar ve ra ld ur "
    "ro ic ne me li ll be ma la el so ho ta no om co ch di us wo wa ow il ce ri io tr ec ut ct ns "
    "ac ot lo pe do un wh ei "
    "em mo rs ss id ad pr ai sh wi sp fo ee ul po ke rk rt ge ay ca pa tt ts im am ie mp ir ab ag "
    "ev ly oo op iv ol vi da "
    "fa ry ye su bl ef ap pl fi fr ck bo gh ig os up gr ty ff ni na mi sc ba by br ex av uc ue ua "
    "ga go gi if";

/// Words that people often choose as a secret, and words of this farm.
constexpr std::array<std::string_view, 40> kWords = {
    "password",    "passwort", "passphrase", "letmein",  "welcome",   "changeme", "terravox",
    "coordinator", "secret",   "worker",     "render",   "raytracer", "voxel",    "token",
    "farm",        "admin",    "login",      "default",  "example",   "testing",  "test",
    "hello",       "dragon",   "monkey",     "football", "iloveyou",  "sunshine", "princess",
    "shadow",      "master",   "superman",   "batman",   "trustno",   "qwerty",   "asdf",
    "zxcv",        "server",   "network",    "cluster",  "company"};

constexpr std::array<std::string_view, 4> kRows = {"qwertyuiop", "asdfghjkl", "zxcvbnm",
                                                   "1234567890"};

bool is_lower(char c) noexcept {
    return c >= 'a' && c <= 'z';
}
bool is_upper(char c) noexcept {
    return c >= 'A' && c <= 'Z';
}
bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}
bool is_letter(char c) noexcept {
    return is_lower(c) || is_upper(c);
}

/// The letter that a digit or a sign often replaces.
char as_letter(char c) noexcept {
    constexpr std::string_view kWritten = "01345$7@!";
    constexpr std::string_view kMeant = "oieassta";
    if (c == '!')
        return 'i';
    const auto at = kWritten.find(c);
    return at < kMeant.size() ? kMeant[at] : util::lower_case(c);
}

bool is_frequent_pair(char a, char b) noexcept {
    for (std::size_t i = 0; i + 1 < kPairs.size(); i += 3)
        if (kPairs[i] == a && kPairs[i + 1] == b)
            return true;
    return false;
}

bool goes_on(char before, char c) noexcept {
    const int step = c - before;
    if (step >= -1 && step <= 1)
        return true;
    for (const std::string_view row : kRows) {
        const auto a = row.find(before);
        const auto b = row.find(c);
        if (a != std::string_view::npos && b != std::string_view::npos &&
            (a + 1 == b || b + 1 == a))
            return true;
    }
    return false;
}

/// Number of characters from here on that occurred in the token before; the copy may overlap its
/// original.
std::size_t copied_from_before(std::string_view plain, std::size_t at) noexcept {
    std::size_t longest = 0;
    for (std::size_t from = 0; from < at; ++from) {
        std::size_t length = 0;
        while (at + length < plain.size() && plain[from + length] == plain[at + length])
            ++length;
        longest = std::max(longest, length);
    }
    return longest;
}

std::size_t word_at(std::string_view meant, std::size_t at) noexcept {
    std::size_t longest = 0;
    for (const std::string_view word : kWords)
        if (meant.substr(at).starts_with(word))
            longest = std::max(longest, word.size());
    return longest;
}

bool is_year_at(std::string_view token, std::size_t at) noexcept {
    const std::string_view year = token.substr(at, kYearDigits);
    return year.size() == kYearDigits && std::all_of(year.begin(), year.end(), is_digit) &&
           (year.starts_with("19") || year.starts_with("20"));
}

double letter_bits(std::string_view token, std::size_t at) noexcept {
    const char c = token[at];
    if (at == 0 || !is_letter(token[at - 1]))
        return kLetter_bits;
    const char before = token[at - 1];
    const double bits = is_frequent_pair(util::lower_case(before), util::lower_case(c))
                            ? kFrequentPair_bits
                            : kLetter_bits;
    return bits + (is_upper(before) != is_upper(c) ? kCase_bits : 0);
}

}  // namespace

double estimated_bits(std::string_view token) {
    std::string plain;
    std::string meant;
    for (const char c : token) {
        plain += util::lower_case(c);
        meant += as_letter(c);
    }
    double bits = 0;
    for (std::size_t i = 0; i < token.size();) {
        const char c = token[i];
        if (const std::size_t copied = copied_from_before(plain, i); copied >= kMinCopy) {
            bits += kCopied_bits * static_cast<double>(copied);
            i += copied;
        } else if (const std::size_t word = word_at(meant, i); word > 0) {
            bits += kWord_bits;
            i += word;
        } else if (is_year_at(token, i)) {
            bits += kYear_bits * kYearDigits;
            i += kYearDigits;
        } else {
            if (i > 1 && goes_on(plain[i - 2], plain[i - 1]) && goes_on(plain[i - 1], plain[i]))
                bits += kRun_bits;
            else if (is_letter(c))
                bits += letter_bits(token, i);
            else if (is_digit(c))
                bits += kDigit_bits;
            else
                bits += token.substr(0, i).find(c) == std::string_view::npos ? kSign_bits
                                                                             : kSameSign_bits;
            ++i;
        }
    }
    return bits;
}

std::string weakness_of(std::string_view token) {
    static constexpr std::string_view kMakeOne =
        "; `openssl rand -hex 16` makes one, and so does `terravox worker --listen` without any";
    if (token.size() < kMinToken)
        return "the token has " + std::to_string(token.size()) + " characters; allowed: at least " +
               std::to_string(kMinToken) + std::string(kMakeOne);
    const double bits = estimated_bits(token);
    if (bits >= kMinToken_bits)
        return {};
    std::array<char, 128> text{};
    std::snprintf(text.data(), text.size(),
                  "the token can be guessed (about %.0f bits); allowed: at least %.0f bits", bits,
                  kMinToken_bits);
    return text.data() + std::string(kMakeOne);
}

}  // namespace terravox::net
