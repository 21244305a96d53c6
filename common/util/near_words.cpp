#include "common/util/near_words.hpp"

#include <algorithm>
#include <utility>

#include "common/util/letter_case.hpp"

namespace terravox::util {
namespace {

constexpr std::size_t kMostEdits = 3;
constexpr std::size_t kMostWords = 3;
/// Of a word's beginning, for words that begin so.
constexpr std::size_t kFewestLetters = 3;

/// Without hyphens in front, in lower case.
std::string bare(std::string_view word) {
    const std::size_t from = word.find_first_not_of('-');
    return from == std::string_view::npos ? std::string{} : lower_case(word.substr(from));
}

/// Whether so few edits leave enough in common.
bool is_near(std::size_t edits, std::size_t longer) {
    return edits <= kMostEdits && 5 * edits < 3 * longer;
}

std::vector<std::string> words_that_begin_with(std::string_view beginning,
                                               std::span<const std::string> known) {
    if (beginning.size() < kFewestLetters)
        return {};
    std::vector<std::string> out;
    for (const std::string& word : known)
        if (bare(word).starts_with(beginning))
            out.push_back(word);
    return out.size() <= kMostWords ? out : std::vector<std::string>{};
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
    // Rows of the table of distances between the beginnings of a and b: the last two, and this one.
    std::vector<std::size_t> before_last;
    std::vector<std::size_t> last(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::vector<std::size_t> row(b.size() + 1);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
        before_last = std::move(last);
        last = std::move(row);
    }
    return last[b.size()];
}

std::vector<std::string> near_words(std::string_view mistyped, std::span<const std::string> known) {
    const std::string typed = bare(mistyped);
    std::size_t fewest = kMostEdits + 1;
    std::vector<std::string> out;
    for (const std::string& word : known) {
        const std::string candidate = bare(word);
        const std::size_t longer = std::max(typed.size(), candidate.size());
        // The difference in length is a lower bound of the edits.
        if (longer - std::min(typed.size(), candidate.size()) > std::min(fewest, kMostEdits))
            continue;
        const std::size_t edits = edit_distance(typed, candidate);
        if (edits > fewest || !is_near(edits, longer))
            continue;
        if (edits < fewest)
            out.clear();
        fewest = edits;
        out.push_back(word);
    }
    return out.empty() ? words_that_begin_with(typed, known) : out;
}

std::string did_you_mean(std::span<const std::string> near) {
    std::string out = "; did you mean " + comma_list(near.first(near.size() - 1));
    return out + (near.size() > 1 ? " or " : "") + near.back() + "?";
}

std::string did_you_mean(std::string_view mistyped, std::span<const std::string> known) {
    const std::vector<std::string> near = near_words(mistyped, known);
    return near.empty() ? std::string{} : did_you_mean(near);
}

std::string allowed_words(std::string_view mistyped, std::span<const std::string> known) {
    const std::string meant = did_you_mean(mistyped, known);
    return (meant.empty() ? ";" : meant) + " allowed: " + comma_list(known);
}

std::string comma_list(std::span<const std::string> words) {
    std::string out;
    for (const std::string& word : words)
        out += (out.empty() ? "" : ", ") + word;
    return out;
}

}  // namespace terravox::util
