#pragma once

#include <grpcpp/security/auth_context.h>
#include <openssl/x509.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace terravox::net {

/// Roles that a certificate may grant. The role is in the certificate as a URI among its
/// alternative names: kRoleUri and the role.
inline constexpr std::string_view kWorkerRole = "worker";  ///< renders for coordinators
/// has pictures rendered; queries states, and pauses
inline constexpr std::string_view kCoordinatorRole = "coordinator";
inline constexpr std::string_view kRoleUri = "urn:terravox:farm:";

/// @return kWorkerRole, kCoordinatorRole, or empty: it names none
[[nodiscard]] std::string role_of(X509* certificate);

/// The list of revoked certificates of a CA (X.509 CRL, PEM), which is next to it: ca.crl for
/// ca.pem. It is read for each connection, and again for existing ones once its file has changed
/// (RevocationWatch).
[[nodiscard]] std::filesystem::path revocation_list_of(const std::filesystem::path& ca);

/// What a certificate states about its owner.
struct Certified {
    std::string role;  ///< kWorkerRole or kCoordinatorRole
    std::string name;  ///< its common name
    std::string pem;   ///< all of it
};

/// The contents of the certificate of the other end of a TLS connection, which gRPC has verified to
/// be of this CA.
/// @param ca file of the CA's certificate
/// @throws RefusedError for a certificate without kFarmName or a role, or one that is revoked;
/// Error for a list of revoked ones that cannot be read, or that this CA has not signed: then no
/// peer is admitted
[[nodiscard]] Certified certified_peer(const grpc::AuthContext& context,
                                       const std::filesystem::path& ca);

/// Checks whether an admitted certificate has been revoked since. Thread-safe.
///
/// A check costs a stat() while the list's file is unchanged. A list that cannot be read, such as
/// one that is just being copied, is logged and read again with the next check; until then existing
/// links stay, while new connections are refused.
class RevocationWatch {
public:
    /// @param certificate PEM
    /// @param ca file of the CA's certificate
    RevocationWatch(std::string certificate, std::filesystem::path ca);
    [[nodiscard]] bool is_revoked();

private:
    /// Identifies a version of a file: device, inode, size, and times of content and inode in ns;
    /// nullopt: there is no file.
    using Stamp = std::optional<std::array<std::int64_t, 5>>;
    [[nodiscard]] static Stamp stamp_of(const std::filesystem::path& file) noexcept;

    const std::string m_certificate;
    const std::filesystem::path m_ca;
    const std::filesystem::path m_list;
    std::mutex m_mutex;
    /// Of the list that was read last, and of the last one that could not be.
    Stamp m_read;
    Stamp m_reported;
    bool m_revoked = false;
};

}  // namespace terravox::net
