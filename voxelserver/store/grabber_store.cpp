#include "voxelserver/store/grabber_store.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::store {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{128} << 20;  // some 100,000 squares
constexpr std::size_t kMostSquares = 100'000, kMostUnfinished = 10'000, kMostValues = 40 * kMostSquares;
constexpr int kDeepest = 8;  // objects and lists within each other: a record has 5
constexpr std::size_t kLongestText = 4096;

/// The grabber's manifest.json, version 1 (grabber/src/store/manifest.ts).
class ManifestReader {
public:
    explicit ManifestReader(fs::path folder) : m_folder(std::move(folder)), m_file(m_folder / "manifest.json") {}

    [[nodiscard]] std::vector<StoredSquare> squares() const {
        const json root = parse();
        if (!root.is_object()) fail("is no object");
        const auto version = root.find("version");
        if (version == root.end() || !version->is_number_integer() || *version != 1) fail("version is not 1");
        const auto list = root.find("squares");
        if (list == root.end() || !list->is_array()) fail("squares is no list");
        if (list->size() > kMostSquares) fail(std::to_string(list->size()) + " squares; allowed: up to " + std::to_string(kMostSquares));
        std::vector<StoredSquare> out;
        for (const json& record : *list) out.push_back(square(record, "squares." + std::to_string(out.size()) + "."));
        return out;
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw Error("read the store's list " + m_file.string() + ": " + what); }

    [[nodiscard]] json parse() const {
        std::error_code failed;
        if (!fs::is_regular_file(m_file, failed)) fail("not a plain file");
        if (const std::uintmax_t size = fs::file_size(m_file, failed); failed || size > kMostBytes)
            fail(failed ? failed.message() : std::to_string(size) + " bytes; allowed: up to " + std::to_string(kMostBytes));
        std::ifstream in(m_file, std::ios::binary);
        if (!in) fail("cannot be read");
        std::size_t values = 0;
        const auto look = [&](int depth, json::parse_event_t, json&) {
            if (depth > kDeepest) fail("nested deeper than " + std::to_string(kDeepest));
            if (++values > kMostValues) fail("holds more than " + std::to_string(kMostValues) + " values");
            return true;
        };
        try {
            return json::parse(in, look);
        } catch (const json::exception& e) {
            std::string why = e.what();
            std::replace_if(why.begin(), why.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
            fail("not JSON: " + why.substr(0, 200));
        }
    }

    [[nodiscard]] static bool plain(const std::string& text) {
        return text.size() <= kLongestText && std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; });
    }

    /// @return empty for null or no such field, when `required` is not set
    [[nodiscard]] std::string text(const json& record, const std::string& where, const char* name, bool required) const {
        const auto found = record.find(name);
        if (found == record.end() || found->is_null()) {
            if (required) fail(where + name + " is missing");
            return {};
        }
        if (!found->is_string()) fail(where + name + " is no text");
        std::string out = found->get<std::string>();
        if (!plain(out)) fail(where + name + " is no line of up to " + std::to_string(kLongestText) + " characters");
        return out;
    }

    [[nodiscard]] std::uint64_t count(const json& record, const std::string& where, const char* name) const {
        const auto found = record.find(name);
        if (found == record.end() || !found->is_number_unsigned() || *found == 0U) fail(where + name + " is no whole number above 0");
        return found->get<std::uint64_t>();
    }

    [[nodiscard]] std::array<double, 3> corner(const json& bounds, const std::string& where, const char* name) const {
        const auto found = bounds.find(name);
        std::array<double, 3> out{};
        bool good = found != bounds.end() && found->is_array() && found->size() == out.size();
        for (std::size_t i = 0; good && i < out.size(); ++i) {
            good = (*found)[i].is_number();
            if (good) out[i] = (*found)[i].get<double>();
            good = good && std::isfinite(out[i]);
        }
        if (!good) fail(where + name + " are not three numbers");
        return out;
    }

    /// Names become parts of paths and of pages.
    [[nodiscard]] std::string name(const json& record, const std::string& where, const char* field) const {
        std::string out = text(record, where, field, true);
        if (out.empty() || out == "." || out == ".." || out.find_first_of("/\\") != std::string::npos) fail(where + field + " = '" + out + "' is no name");
        return out;
    }

    [[nodiscard]] StoredSquare square(const json& record, const std::string& where) const {
        if (!record.is_object()) fail(where + " is no object");
        StoredSquare out;
        out.name = name(record, where, "square"), out.source = name(record, where, "source");
        out.crs = text(record, where, "crs", false), out.class_table = text(record, where, "class_table", false);
        out.licence = text(record, where, "licence", false), out.attribution = text(record, where, "attribution", false);
        if (const auto error = record.find("last_error"); error != record.end() && !error->is_null()) {
            if (!error->is_object()) fail(where + "last_error is no object");
            out.error = one_line(*error, where + "last_error.");
        }
        const std::string state = text(record, where, "state", true);
        if (state == "verified") verified(record, where, out);
        else if (state == "missing") out.state = StoredState::kMissing;
        else if (state == "failed") out.state = StoredState::kFailed;
        else fail(where + "state = '" + state + "'; allowed: verified, missing, failed");
        return out;
    }

    // What a server or a system said: it may be long, or of several lines.
    [[nodiscard]] std::string one_line(const json& error, const std::string& where) const {
        const auto found = error.find("message");
        if (found == error.end() || !found->is_string()) fail(where + "message is no text");
        std::string out = found->get<std::string>();
        std::replace_if(out.begin(), out.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
        if (out.size() > kLongestText) {
            std::size_t end = kLongestText;
            while (end > 0 && (static_cast<unsigned char>(out[end]) & 0xC0) == 0x80) --end;  // not within a character
            out.resize(end);
        }
        return out;
    }

    void verified(const json& record, const std::string& where, StoredSquare& out) const {
        const auto file = record.find("file");
        if (file == record.end() || !file->is_object()) fail(where + "file is no object");
        const std::string inner = where + "file.";
        const std::string path = text(*file, inner, "path", true);
        if (!allowed(path)) fail(inner + "path = '" + path + "'; allowed: lidar/<source>/<square>.laz or .las");
        out.bytes = count(*file, inner, "bytes"), out.points = count(*file, inner, "point_count");
        if (const auto bounds = file->find("bounds"); bounds != file->end() && !bounds->is_null()) {
            if (!bounds->is_object()) fail(inner + "bounds is no object");
            out.bounds = StoredBounds{corner(*bounds, inner + "bounds.", "min"), corner(*bounds, inner + "bounds.", "max")};
        }
        std::error_code failed;
        const fs::path at = m_folder / path;
        const std::uintmax_t size = fs::is_regular_file(at, failed) ? fs::file_size(at, failed) : 0;
        out.error.clear();
        if (!failed && size == out.bytes) {
            out.state = StoredState::kFetched, out.file = at;
            return;
        }
        out.state = StoredState::kFailed;
        out.error = size == 0 ? path + " is not there any more; fetch it again"
                              : path + " has " + std::to_string(size) + " bytes; it had " + std::to_string(out.bytes) + " when it was fetched";
    }

    // As the grabber writes them: no other folder can be meant.
    [[nodiscard]] static bool allowed(const std::string& path) {
        constexpr std::string_view kRoot = "lidar/";
        if (!path.starts_with(kRoot) || !(path.ends_with(".laz") || path.ends_with(".las"))) return false;
        const std::size_t slash = path.find('/', kRoot.size());
        if (slash == std::string::npos || slash == kRoot.size()) return false;
        const std::string folder = path.substr(kRoot.size(), slash - kRoot.size()), file = path.substr(slash + 1);
        return std::all_of(folder.begin(), folder.end(), [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; }) &&
               file.size() > 4 && file.find_first_of("/\\") == std::string::npos;
    }

    const fs::path m_folder, m_file;
};

/// Files that the grabber has begun: lidar/<source>/.<square>.part
void add_unfinished(const fs::path& folder, std::vector<StoredSquare>& squares) {
    std::error_code failed;
    std::size_t found = 0;
    for (fs::directory_iterator source(folder / "lidar", failed), end; !failed && source != end; source.increment(failed)) {
        std::error_code inner;
        for (fs::directory_iterator file(source->path(), inner); !inner && file != end && found < kMostUnfinished; file.increment(inner)) {
            const std::string name = file->path().filename().string();
            constexpr std::string_view kEnding = ".part";
            if (name.size() <= kEnding.size() + 1 || name[0] != '.' || !name.ends_with(kEnding)) continue;
            StoredSquare s;
            s.name = name.substr(1, name.size() - 1 - kEnding.size()), s.source = source->path().filename().string();
            squares.push_back(std::move(s));
            ++found;
        }
    }
}

}  // namespace

std::vector<fs::path> GrabberStore::files() const {
    std::vector<fs::path> out;
    for (const StoredSquare& s : squares)
        if (s.state == StoredState::kFetched) out.push_back(s.file);
    return out;
}

GrabberStore read_grabber_store(const fs::path& folder) {
    const auto fail = [&](const std::string& what) { return Error("read the store " + folder.string() + ": " + what); };
    std::error_code failed;
    if (!fs::is_directory(folder, failed)) throw fail("no such folder");
    GrabberStore out;
    if (fs::exists(folder / "manifest.json", failed)) out.squares = ManifestReader(folder).squares();
    else if (!fs::is_directory(folder / "lidar", failed) && !fs::exists(folder / ".grabber.lock", failed))
        throw fail("it has no manifest.json; allowed: a folder that the grabber fills");
    add_unfinished(folder, out.squares);
    // Unfinished ones come last: what the list says of a square holds, but one that has failed and is being fetched again is wanted.
    std::map<std::pair<std::string, std::string>, StoredSquare> squares;
    for (StoredSquare& s : out.squares) {
        const auto [at, added] = squares.try_emplace({s.source, s.name}, s);
        if (added) continue;
        if (s.state != StoredState::kWanted) throw fail("its list names " + s.source + "/" + s.name + " twice");
        if (at->second.state != StoredState::kFetched) at->second.state = StoredState::kWanted, at->second.error.clear();
    }
    out.squares.clear();
    for (auto& [key, s] : squares) out.squares.push_back(std::move(s));
    if (fs::is_directory(folder / "orthophotos", failed)) out.orthophotos = folder / "orthophotos";
    return out;
}

const char* name_of(StoredState state) noexcept {
    switch (state) {
        case StoredState::kWanted: return "wanted";
        case StoredState::kFetched: return "fetched";
        case StoredState::kFailed: return "failed";
        case StoredState::kMissing: return "missing";
    }
    return "failed";
}

}  // namespace terravox::store
