#include "common/util/temporary_folder.hpp"

#include <cstdlib>
#include <system_error>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

TemporaryFolder TemporaryFolder::make(const std::string& attempt) {
    std::string name = (fs::temp_directory_path() / "terravox-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw Error(attempt + ": no folder can be made in " + fs::temp_directory_path().string() +
                    "; TMPDIR names another place");
    TemporaryFolder out;
    out.m_path = name;
    return out;
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : m_path(std::exchange(other.m_path, {})) {}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
    std::swap(m_path, other.m_path);
    return *this;
}

TemporaryFolder::~TemporaryFolder() {
    remove();
}

void TemporaryFolder::remove() noexcept {
    constexpr int kAttempts = 100;
    for (int i = 0; i < kAttempts && !m_path.empty(); ++i) {
        std::error_code failed;
        fs::remove_all(m_path, failed);
        if (!failed)
            m_path.clear();
    }
}

}  // namespace terravox::util
