#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::minecraft {

void UnknownNames::add(std::string_view name) {
    // A file of made-up names must not fill the memory.
    constexpr std::size_t kMax = 100'000;
    const std::lock_guard lock(m_mutex);
    if (m_names.size() >= kMax || !m_names.emplace(name).second)
        return;
    if (m_names.size() <= kLogged)
        util::log_warn("{} {}: it is shown as material 'unknown'", m_attempt, name);
    if (m_names.size() == kLogged)
        util::log_warn("further unknown names are not reported one by one");
}

std::size_t UnknownNames::count() const {
    const std::lock_guard lock(m_mutex);
    return m_names.size();
}

namespace {

std::string_view without_namespace(std::string_view name) noexcept {
    const auto colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

bool all_hold(const std::vector<Condition>& conditions, Properties properties) noexcept {
    return std::all_of(conditions.begin(), conditions.end(),
                       [&](const Condition& c) { return c.holds(properties); });
}

}  // namespace

BlockAppearance BlockTable::chosen(const Candidate& candidate, Properties properties) const {
    BlockAppearance appearance = candidate.appearance;
    if (candidate.fixed || !m_drowned[static_cast<std::size_t>(appearance.material)])
        return appearance;
    const auto drowned = [](const Property& p) {
        return p.name == "waterlogged" && p.value == "true";
    };
    if (std::any_of(properties.begin(), properties.end(), drowned))
        appearance = {voxel::Material::kWater, false, {}, true};
    return appearance;
}

BlockAppearance BlockTable::find_appearance(std::string_view name, Properties properties) const {
    if (const auto found = m_names.find(name); found != m_names.end())
        for (const Candidate& candidate : found->second)
            if (all_hold(candidate.conditions, properties))
                return chosen(candidate, properties);
    for (const auto& [pattern, candidate] : m_wildcards)
        if (fits(pattern, name) && all_hold(candidate.conditions, properties))
            return chosen(candidate, properties);
    return {};
}

BlockAppearance BlockTable::of(std::string_view name, Properties properties) const {
    name = without_namespace(name);
    const auto renamed = m_renamed.find(name);
    if (renamed == m_renamed.end())
        return find_appearance(name, properties);
    std::vector<Property> all(properties.begin(), properties.end());
    for (const Condition& c : renamed->second.conditions)
        all.push_back({c.property, c.values.front()});
    return find_appearance(renamed->second.name, all);
}

BlockAppearance BlockTable::of_number(int id, int data) const {
    if (id < 0 || id >= kNumbers)
        return {};
    return m_number_appearances[static_cast<std::size_t>(id * kData + (data & (kData - 1)))];
}

std::string BlockTable::name_of_number(int id, int data) const {
    data &= kData - 1;
    if (id < 0 || id >= kNumbers || m_number_names[static_cast<std::size_t>(id)].empty())
        return std::to_string(id) + ":" + std::to_string(data);
    const auto& names = m_number_names[static_cast<std::size_t>(id)];
    const std::size_t place = static_cast<std::size_t>(data) & (std::bit_ceil(names.size()) - 1);
    return names[place < names.size() ? place : 0];
}

void BlockTable::overlay(const std::map<std::string, voxel::Material>& blocks) {
    for (const auto& [full_name, material] : blocks) {
        const std::string name(without_namespace(full_name));
        Candidate candidate;
        candidate.appearance = of(name, {});
        candidate.appearance.material = material;
        candidate.appearance.known = true;
        candidate.fixed = true;
        m_renamed.erase(name);
        m_names[name] = {candidate};
    }
}

namespace {}  // namespace

/// Reads the files of a block table.
class BlockTableReader {
public:
    /// @param old the older names and the numbers; empty: the table has none
    BlockTableReader(std::filesystem::path blocks, std::filesystem::path old)
        : m_blocks(std::move(blocks)), m_old(std::move(old)) {}

    BlockTable read() {
        m_file = &m_blocks;
        const toml::table blocks =
            util::read_toml(m_blocks, [&](const std::string& what) { fail(what); });
        read_words(blocks);
        for (const auto& [key, node] : blocks) {
            if (key.str() == "words")
                continue;
            if (key.str() == "waterlogged")
                read_drowned(node);
            else
                read_material(std::string(key.str()), node);
        }
        sort();
        if (!m_old.empty())
            read_old();
        look_up_numbers();
        return std::move(m_table);
    }

private:
    using Candidate = BlockTable::Candidate;

    [[noreturn]] void fail(const std::string& what) const {
        throw util::UsageError("read the blocks {}: {}", m_file->string(), what);
    }
    [[nodiscard]] Fail failing(std::string where) const {
        return [this, where = std::move(where)](const std::string& what) {
            fail("[" + where + "] " + what);
        };
    }
    [[nodiscard]] const toml::table& make_table(const std::string& name,
                                                const toml::node& node) const {
        if (!node.is_table())
            fail(name + " = " + util::toml_value(node) + "; allowed: a table [" + name + "]");
        return *node.as_table();
    }
    [[nodiscard]] std::string to_text(const std::string& where, const toml::node& node,
                                      const char* allowed) const {
        if (!node.is_string())
            fail(where + " = " + util::toml_value(node) + "; allowed: " + allowed);
        return node.as_string()->get();
    }
    [[nodiscard]] voxel::Material to_material(const std::string& name) const {
        const auto material = voxel::material_from_name(name);
        if (material)
            return *material;
        std::string all;
        for (int i = 0; i < voxel::kMaterialCount; ++i)
            all += (i == 0 ? "" : ", ") +
                   std::string(voxel::material_name(static_cast<voxel::Material>(i)));
        fail("'" + name + "' is no material; allowed: " + all + ", and words, waterlogged");
    }

    void read_words(const toml::table& blocks) {
        const toml::node* words = blocks.get("words");
        if (words == nullptr)
            return;
        for (const auto& [key, node] : make_table("words", *words)) {
            const std::string name(key.str());
            const std::string where = "[words] " + name;
            auto& list = m_words[name];
            if (const auto* texts = node.as_array()) {
                for (const auto& text : *texts)
                    list.push_back({to_text(where, text, "texts"), std::nullopt});
            } else if (const auto* table = node.as_table()) {
                for (const auto& [word, value] : *table) {
                    const auto colour = voxel::rgb8_from_hex(
                        to_text(where + "." + std::string(word.str()), value, "\"#rrggbb\""));
                    if (!colour)
                        fail(where + "." + std::string(word.str()) + " = " +
                             util::toml_value(value) + "; allowed: \"#rrggbb\"");
                    list.push_back({std::string(word.str()), colour});
                }
            } else {
                fail(where + " = " + util::toml_value(node) +
                     "; allowed: a list of texts, or a table of colours");
            }
        }
    }

    void read_drowned(const toml::node& node) {
        const auto* list = node.as_array();
        if (list == nullptr)
            fail("waterlogged = " + util::toml_value(node) + "; allowed: a list of materials");
        for (const auto& item : *list)
            m_table.m_drowned[static_cast<std::size_t>(
                to_material(to_text("waterlogged", item, "a list of materials")))] = true;
    }

    void read_material(const std::string& name, const toml::node& node) {
        const voxel::Material material = to_material(name);
        for (const auto& [key, value] : make_table(name, node))
            read_entry(material, name, key.str(), value);
    }

    void read_entry(voxel::Material material, const std::string& where, std::string_view pattern,
                    const toml::node& value) {
        const Fail fails = failing(where);
        const std::string colour = to_text("[" + where + "] \"" + std::string(pattern) + "\"",
                                           value, R"("#rrggbb", "{word}" or "")");
        BlockState state = block_state_from(pattern, fails);
        for (const Expanded& expanded : expand(state.name, m_words, fails)) {
            Candidate candidate;
            candidate.conditions = state.conditions;
            candidate.own = own_letters(state.name);
            candidate.appearance = {material, !colour.empty(), {}, true};
            if (!colour.empty())
                candidate.appearance.colour = parse_colour(
                    colour, expanded, "[" + where + "] \"" + std::string(pattern) + "\"");
            if (++m_entries > kMaxEntries)
                fail("more than " + std::to_string(kMaxEntries) + " names; allowed: up to that");
            if (expanded.name.find('*') == std::string::npos)
                m_table.m_names[expanded.name].push_back(std::move(candidate));
            else
                m_table.m_wildcards.push_back({expanded.name, std::move(candidate)});
        }
    }

    [[nodiscard]] voxel::Rgb8 parse_colour(const std::string& text, const Expanded& expanded,
                                           const std::string& where) const {
        if (const auto colour = voxel::rgb8_from_hex(text))
            return *colour;
        if (text.size() > 2 && text.front() == '{' && text.back() == '}') {
            const auto word = expanded.chosen.find(text.substr(1, text.size() - 2));
            if (word != expanded.chosen.end() && word->second->colour)
                return *word->second->colour;
        }
        fail(where + " = '" + text +
             "'; allowed: \"#rrggbb\", \"\", or a {word} of the name that has colours");
    }

    static bool better(const Candidate& a, const Candidate& b) {
        return a.own != b.own ? a.own > b.own : a.conditions.size() > b.conditions.size();
    }

    /// Best first. Two of equal rank with the same conditions are an error.
    void sort() {
        for (auto& [name, list] : m_table.m_names) {
            std::stable_sort(list.begin(), list.end(), better);
            for (std::size_t i = 1; i < list.size(); ++i)
                if (!better(list[i - 1], list[i]) && list[i - 1].conditions == list[i].conditions)
                    fail("'" + name + "' is meant twice, by " + twice(list[i - 1], list[i]));
        }
        std::stable_sort(m_table.m_wildcards.begin(), m_table.m_wildcards.end(),
                         [](const auto& a, const auto& b) {
                             if (a.pattern.size() != b.pattern.size())
                                 return a.pattern.size() > b.pattern.size();
                             return a.candidate.conditions.size() > b.candidate.conditions.size();
                         });
    }
    static std::string twice(const Candidate& a, const Candidate& b) {
        return "[" + std::string(voxel::material_name(a.appearance.material)) + "] and [" +
               std::string(voxel::material_name(b.appearance.material)) + "]; allowed: once";
    }

    /// A block with its properties.
    /// @throws Error unless the table has it
    BlockTable::Renamed known(const std::string& where, const std::string& text) const {
        BlockState state = block_state_from(text, failing(where));
        std::vector<Property> properties;
        for (const Condition& c : state.conditions) {
            if (c.values.size() != 1)
                fail("[" + where + "] '" + text + "' leaves " + c.property +
                     " open; allowed: one value");
            properties.push_back({c.property, c.values.front()});
        }
        if (!m_table.find_appearance(state.name, properties).known)
            fail("[" + where + "] '" + text + "' is none of blocks.toml");
        return {std::move(state.name), std::move(state.conditions)};
    }

    void read_old() {
        m_file = &m_old;
        const toml::table old =
            util::read_toml(m_old, [&](const std::string& what) { fail(what); });
        for (const auto& [key, node] : old) {
            if (key.str() == "renamed")
                read_renamed(make_table("renamed", node));
            else if (key.str() == "numbers")
                read_numbers(make_table("numbers", node));
            else
                fail("'" + std::string(key.str()) + "' is no part; allowed: renamed, numbers");
        }
    }

    void read_renamed(const toml::table& table) {
        for (const auto& [key, node] : table) {
            const std::string name(key.str());
            if (m_table.m_names.contains(name))
                fail("[renamed] '" + name +
                     "' is a block of blocks.toml; allowed: names that are none");
            m_table.m_renamed[name] =
                known("renamed", to_text("[renamed] " + name, node, "the name of a block"));
        }
    }

    void read_numbers(const toml::table& table) {
        m_table.m_number_names.assign(BlockTable::kNumbers, {});
        for (const auto& [key, node] : table) {
            const std::string_view text = key.str();
            int number = -1;
            const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
            if (end.ec != std::errc{} || end.ptr != text.data() + text.size() || number < 0 ||
                number >= BlockTable::kNumbers)
                fail("[numbers] '" + std::string(text) +
                     "' is no number of a block; allowed: 0 to " +
                     std::to_string(BlockTable::kNumbers - 1));
            const auto* list = node.as_array();
            if (list == nullptr || list->empty() || list->size() > BlockTable::kData)
                fail("[numbers] " + std::string(text) + " = " + util::toml_value(node) +
                     "; allowed: a list of 1 to 16 names");
            for (const auto& item : *list) {
                std::string name =
                    to_text("[numbers] " + std::string(text), item, "a list of names");
                (void)known("numbers", name);
                m_table.m_number_names[static_cast<std::size_t>(number)].push_back(std::move(name));
            }
        }
    }

    void look_up_numbers() {
        m_table.m_number_names.resize(BlockTable::kNumbers);
        m_table.m_number_appearances.resize(std::size_t{BlockTable::kNumbers} * BlockTable::kData);
        for (int id = 0; id < BlockTable::kNumbers; ++id)
            for (int data = 0; data < BlockTable::kData; ++data) {
                if (m_table.m_number_names[static_cast<std::size_t>(id)].empty())
                    continue;
                const BlockState state =
                    block_state_from(m_table.name_of_number(id, data), failing("numbers"));
                std::vector<Property> properties;
                for (const Condition& c : state.conditions)
                    properties.push_back({c.property, c.values.front()});
                m_table
                    .m_number_appearances[static_cast<std::size_t>(id * BlockTable::kData + data)] =
                    m_table.find_appearance(state.name, properties);
            }
    }

    static constexpr std::size_t kMaxEntries = 50'000;
    const std::filesystem::path m_blocks;
    const std::filesystem::path m_old;
    const std::filesystem::path* m_file = nullptr;
    Words m_words;
    std::size_t m_entries = 0;
    BlockTable m_table;
};

BlockTable BlockTable::load(const std::filesystem::path& folder) {
    return BlockTableReader(folder / "blocks.toml", folder / "old-blocks.toml").read();
}

BlockTable BlockTable::load_names(const std::filesystem::path& file) {
    return BlockTableReader(file, {}).read();
}

}  // namespace terravox::minecraft
