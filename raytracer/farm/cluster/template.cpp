#include "raytracer/farm/cluster/template.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"

namespace terravox::cluster {

class Filler {
public:
    Filler(std::string_view name, const Values& values)
        : m_name(name), m_is_json(name.ends_with(".json")), m_values(values) {}

    [[nodiscard]] std::string run() {
        const auto file = util::config_dir() / "cluster" / (m_name + ".in");
        std::ifstream in(file);
        if (!in)
            throw util::Error("fill the template " + file.string() + ": it cannot be read");
        std::string out;
        for (std::string line; std::getline(in, line);)
            out += fill_line(line);
        for (const auto& [name, value] : m_values)
            if (!m_used.contains(name))
                refuse("has no {{" + name + "}}");
        return m_is_json ? write_anew(out) : out;
    }

private:
    static constexpr std::string_view kOpen = "{{";
    static constexpr std::string_view kClose = "}}";

    [[noreturn]] void refuse(const std::string& what) const {
        std::string names;
        for (const auto& [name, value] : m_values)
            names += (names.empty() ? "" : ", ") + name;
        throw util::Error("fill the template config/cluster/" + m_name + ".in: it " + what +
                          "; allowed: all of " + names + ", and no others");
    }

    [[nodiscard]] std::string quote(const std::string& word) const {
        if (!m_is_json)
            return util::shell_word(word);
        try {
            return nlohmann::json(word).dump();
        } catch (const nlohmann::json::type_error&) {
            throw util::UsageError("cluster " + m_name.substr(0, m_name.find('/')) +
                                   ": an argument is no UTF-8; allowed: UTF-8, which JSON is "
                                   "written in");
        }
    }

    /// @param at of a list: which of its words
    [[nodiscard]] std::string text_at(const Value& value, std::size_t at) const {
        const std::string& word = value.m_words[value.m_is_list ? at : 0];
        if (value.m_is_quoted)
            return quote(word);
        return word.ends_with('\n') ? word.substr(0, word.size() - 1) : word;
    }

    /// The texts of a line between its names: the even ones; the odd ones are names.
    [[nodiscard]] static std::vector<std::string> split(std::string_view line) {
        std::vector<std::string> out(1);
        while (!line.empty()) {
            const std::size_t open = line.find(kOpen);
            const std::size_t close =
                open == line.npos ? open : line.find(kClose, open + kOpen.size());
            if (close == line.npos)
                break;
            const auto name = line.substr(open + kOpen.size(), close - open - kOpen.size());
            if (!name.empty() && name.front() >= 'A' && name.front() <= 'Z') {
                out.back() += line.substr(0, close + kClose.size());
            } else {
                out.back() += line.substr(0, open);
                out.insert(out.end(), {std::string(name), ""});
            }
            line.remove_prefix(close + kClose.size());
        }
        out.back() += line;
        return out;
    }

    [[nodiscard]] std::string fill_line(std::string_view line) {
        const std::size_t begin = line.find_first_not_of(' ');
        if (begin != line.npos && line.substr(begin).starts_with("{{#"))
            return {};
        const std::vector<std::string> parts = split(line);
        std::size_t times = 1;
        bool has_list = false;
        for (std::size_t i = 1; i < parts.size(); i += 2) {
            const auto found = m_values.find(parts[i]);
            if (found == m_values.end())
                refuse("has {{" + parts[i] + "}}");
            m_used.insert(parts[i]);
            if (!found->second.m_is_list)
                continue;
            if (std::exchange(has_list, true))
                refuse("has two lists in a line");
            times = found->second.m_words.size();
        }
        std::string out;
        for (std::size_t at = 0; at < times; ++at) {
            for (std::size_t i = 0; i < parts.size(); ++i)
                out += i % 2 == 0 ? parts[i] : text_at(m_values.find(parts[i])->second, at);
            out += m_is_json && at + 1 < times ? ",\n" : "\n";
        }
        return out;
    }

    [[nodiscard]] std::string write_anew(const std::string& text) const {
        try {
            return nlohmann::ordered_json::parse(text).dump(2) + "\n";
        } catch (const nlohmann::json::parse_error& e) {
            refuse(std::string("is no JSON: ") + e.what());
        }
    }

    const std::string m_name;
    const bool m_is_json;
    const Values& m_values;
    std::set<std::string> m_used;
};

std::string fill(std::string_view name, const Values& values) {
    return Filler(name, values).run();
}

}  // namespace terravox::cluster
