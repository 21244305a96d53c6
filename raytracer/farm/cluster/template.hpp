#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::cluster {

/// What stands for a name of a template: a word or a number, or a list of them, whose line is
/// written once for each: with an empty list it is left out.
class Value {
public:
    Value(int number) : Value({std::to_string(number)}, false, false) {}
    Value(std::string word) : Value({std::move(word)}, true, false) {}
    Value(const char* word) : Value(std::string(word)) {}
    Value(std::vector<std::string> words) : Value(std::move(words), true, true) {}
    /// Text that is written as it is, without its last line break.
    [[nodiscard]] static Value plain(std::string text) { return {{std::move(text)}, false, false}; }
    [[nodiscard]] static Value plain_list(std::vector<std::string> texts) {
        return {std::move(texts), false, true};
    }
    /// The same for a line that is left out where the text is empty.
    [[nodiscard]] static Value plain_if_any(const std::string& text) {
        return plain_list(text.empty() ? std::vector<std::string>{} : std::vector{text});
    }

    /// A number, for a line that is left out where it is 0 or less.
    [[nodiscard]] static Value if_positive(int number) {
        return plain_if_any(number > 0 ? std::to_string(number) : "");
    }

private:
    friend class Filler;
    Value(std::vector<std::string> words, bool is_quoted, bool is_list)
        : m_words(std::move(words)), m_is_quoted(is_quoted), m_is_list(is_list) {}
    std::vector<std::string> m_words;
    bool m_is_quoted;
    bool m_is_list;
};

using Values = std::map<std::string, Value, std::less<>>;

/// Fills a template of config/cluster: {{name}} becomes its value. Words are quoted so that bash,
/// or a reader of JSON or YAML, gets them back byte for byte; in JSON the lines of a list are
/// separated by commas, and the result is written anew. Lines that begin with {{# are comments.
/// Names that begin with a capital are left to the scheduler.
/// @param name such as "scripts/frames.sh": the file ends in .in; bash, or JSON by .json
/// @throws Error for a template that is not there, that has a name without a value, or no place
/// for a value; UsageError for a word that the language cannot hold
[[nodiscard]] std::string fill(std::string_view name, const Values& values);

}  // namespace terravox::cluster
