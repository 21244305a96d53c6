#include "voxelserver/voxelize/world/store_options.hpp"

#include <set>

#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

using store::GrabberStore;
using store::StoredSquare;
using store::StoredState;

// The one value that all fetched squares have; "" when none has any.
std::string common_value(const GrabberStore& store, std::string StoredSquare::* field,
                         const char* what, const char* flag) {
    std::set<std::string> values;
    for (const StoredSquare& s : store.squares)
        if (s.state == StoredState::kFetched && !(s.*field).empty())
            values.insert(s.*field);
    if (values.size() > 1)
        throw util::UsageError(std::string("open the store: its squares have ") +
                               std::to_string(values.size()) + " different " + what +
                               ", such as '" + *values.begin() + "' and '" + *values.rbegin() +
                               "'; allowed: one, or say which with " + flag);
    return values.empty() ? "" : *values.begin();
}

std::string all_of(const GrabberStore& store, std::string StoredSquare::* field) {
    std::string out;
    std::set<std::string> seen;
    for (const StoredSquare& s : store.squares)
        if (!(s.*field).empty() && seen.insert(s.*field).second)
            out += (out.empty() ? "" : "; ") + s.*field;
    return out;
}

}  // namespace

void take_from_store(const GrabberStore& store, LidarWorldOptions& options) {
    options.files = store.files();
    if (options.files.empty())
        throw util::UsageError(
            "open the store: it has no square yet; fetch some with terravox grab fetch");
    if (options.classes.empty())
        options.classes =
            common_value(store, &StoredSquare::class_table, "class tables", "--classes");
    if (!options.crs)
        if (const std::string crs = common_value(store, &StoredSquare::crs, "CRSs", "--crs");
            !crs.empty())
            options.crs = crs;
    if (options.orthophotos.empty())
        options.orthophotos = store.orthophotos;
}

Terms terms_of(const GrabberStore& store) {
    return {all_of(store, &StoredSquare::licence), all_of(store, &StoredSquare::attribution)};
}

}  // namespace terravox::voxelize
