#include "common/util/command_line.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string_view>
#include <vector>

namespace terravox::util {
namespace {

using Json = nlohmann::ordered_json;

bool is_word(std::string_view text) {
    const auto fits = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    };
    return !text.empty() && text.front() >= 'a' && text.front() <= 'z' &&
           std::all_of(text.begin(), text.end(), fits);
}

/// Splits a text that consists of words between separators.
/// @return none where one of its parts is no word, or where there is only one
std::vector<std::string> words_between(std::string_view text, std::string_view separator) {
    std::vector<std::string> words;
    for (std::size_t from = 0; from <= text.size();) {
        const std::size_t to = std::min(text.find(separator, from), text.size());
        const std::string_view word = text.substr(from, to - from);
        if (!is_word(word))
            return {};
        words.emplace_back(word);
        from = to + separator.size();
    }
    return words.size() > 1 ? words : std::vector<std::string>{};
}

/// The first list of words in round brackets: "tone curve (filmic, linear), default 'linear'".
std::vector<std::string> words_in_brackets(std::string_view text) {
    for (std::size_t open = text.find('('); open != std::string_view::npos;
         open = text.find('(', open + 1)) {
        const std::size_t close = text.find(')', open);
        if (close == std::string_view::npos)
            return {};
        if (auto words = words_between(text.substr(open + 1, close - open - 1), ", ");
            !words.empty())
            return words;
    }
    return {};
}

/// A text that is nothing but a list: "trace, debug or off".
std::vector<std::string> words_of_list(std::string text) {
    if (const auto last = text.rfind(" or "); last != std::string::npos)
        text.replace(last, 4, ", ");
    return words_between(text, ", ");
}

/// @param value as the help shows it: "yes|no", "TEXT:{dtm,dsm}"
std::vector<std::string> list_words(const std::string& value, const std::string& text) {
    const auto open = value.find('{');
    if (const auto close = value.rfind('}'); open != std::string::npos && close > open)
        return words_between(std::string_view(value).substr(open + 1, close - open - 1), ",");
    if (auto words = words_between(value, "|"); !words.empty())
        return words;
    if (auto words = words_of_list(text); !words.empty())
        return words;
    return value == "VALUE" ? words_in_brackets(text) : std::vector<std::string>{};
}

bool is_flag(const CLI::Option& option) {
    return option.get_items_expected_max() == 0;
}

Json list_names(const CLI::Option& option) {
    Json names = Json::array();
    for (const std::string& name : option.get_snames())
        names.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        names.push_back("--" + name);
    return names;
}

Json make_table(const CLI::Option& option) {
    Json out;
    out["names"] = list_names(option);
    out["positional"] = option.get_positional() ? option.get_name(true) : "";
    out["group"] = option.get_group();
    out["text"] = option.get_description();
    out["default"] = option.get_default_str();
    out["required"] = option.get_required();
    out["repeats"] = option.get_items_expected_max() > 1;
    out["value"] = is_flag(option) ? "" : option.get_type_name();
    out["words"] = find_value_words(option);
    return out;
}

Json make_table(const CLI::App& app) {
    Json out;
    out["name"] = app.get_name();
    out["description"] = app.get_description();
    out["footer"] = app.get_footer();
    out["options"] = Json::array();
    for (const CLI::Option* option : app.get_options()) {
        // Without a group: a former name, which no help lists.
        if (!option->get_group().empty())
            out["options"].push_back(make_table(*option));
    }
    out["commands"] = Json::array();
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        out["commands"].push_back(make_table(*command));
    return out;
}

}  // namespace

bool wants_option_tables(int argc, const char* const* argv) {
    return argc == 2 && std::string_view(argv[1]) == "--option-tables";
}

std::string option_tables(const CLI::App& app) {
    return make_table(app).dump(1) + "\n";
}

std::vector<std::string> find_value_words(const CLI::Option& option) {
    if (is_flag(option))
        return {};
    return list_words(option.get_type_name(), option.get_description());
}

}  // namespace terravox::util
