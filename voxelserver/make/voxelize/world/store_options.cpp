#include "voxelserver/make/voxelize/world/store_options.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"

namespace terravox::voxelize {
namespace {

using store::GrabberStore;
using store::StoredOrthophoto;
using store::StoredSquare;

// The one class table that all squares have; kAnyClassTable when none has any.
std::string common_class_table(const std::vector<const StoredSquare*>& squares) {
    std::set<std::string> tables;
    for (const StoredSquare* square : squares)
        if (!square->class_table.empty())
            tables.insert(square->class_table);
    if (tables.size() > 1)
        throw util::UsageError(
            "open the store: its squares have {} different class tables, such as '{}' and '{}'; "
            "allowed: one, or say which with --classes",
            tables.size(), *tables.begin(), *tables.rbegin());
    return tables.empty() ? kAnyClassTable : *tables.begin();
}

/// Distinct texts, one after the other.
class Joined {
public:
    void add(const std::string& text) {
        if (text.empty() || !m_seen.insert(text).second)
            return;
        if (!m_text.empty())
            m_text += "; ";
        m_text += text;
    }
    [[nodiscard]] const std::string& text() const noexcept { return m_text; }

private:
    std::set<std::string> m_seen;
    std::string m_text;
};

/// The title of the one source that all squares are of, else the name of the store's folder.
std::string make_title(const GrabberStore& store, const std::vector<const StoredSquare*>& squares) {
    const std::string& source = squares.front()->source;
    if (std::all_of(squares.begin(), squares.end(),
                    [&](const StoredSquare* square) { return square->source == source; }))
        if (const auto title = grid::source_title(util::config_dir() / "sources", source))
            return *title;
    LidarWorldOptions all;
    all.files = {store.folder};
    return world_title(all);
}

}  // namespace

void take_from_store(const GrabberStore& store, LidarWorldOptions& options) {
    const std::vector<const StoredSquare*> squares = store.fetched();
    if (squares.empty())
        throw util::UsageError(
            "open the store: it has no square yet; fetch some with terravox grab fetch");
    if (options.classes == kAnyClassTable)
        options.classes = common_class_table(squares);
    Joined licences;
    Joined attributions;
    for (const StoredSquare* square : squares) {
        options.files.push_back(square->file);
        if (!square->crs.empty())
            options.recorded_crs.emplace(square->file, square->crs);
        licences.add(square->licence);
        attributions.add(square->attribution);
    }
    if (options.orthophotos.empty()) {
        for (const StoredOrthophoto& photo : store.orthophotos) {
            options.orthophotos.push_back(photo.file);
            licences.add(photo.licence);
            attributions.add(photo.attribution);
        }
    }
    if (options.title.empty())
        options.title = make_title(store, squares);
    options.licence = licences.text();
    options.attribution = attributions.text();
}

}  // namespace terravox::voxelize
